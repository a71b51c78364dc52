#pragma once
// From where a run is looked at, in words.

#include <array>
#include <optional>
#include <string>

namespace drench {

/// A view by name (azimuth and elevation, degrees), or one that is given by numbers.
struct View {
  double azimuth = 32, elevation = 24;
  std::optional<std::array<double, 6>> fixed;  // position and focal point, m
};

/// auto, below, front, top, or six numbers with commas; none for anything else.
std::optional<View> parse_view(const std::string& text);
/// What is said of a text that is no view.
std::string camera_choices(const std::string& text);

}  // namespace drench
