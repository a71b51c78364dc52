#pragma once
// A solid with two legs that face each other closely or overlap, as one mesh.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace drench::test {

/// Adds a prism along z, 2·`half` (m) long, over a polygon (m, counterclockwise) to the text of an OBJ file that has
/// `points` so far. Its sides are divided into faces of at most `face` (m).
inline void add_prism(std::string& text, int& points, const std::vector<std::array<double, 2>>& polygon, double half,
                      double face) {
  std::vector<std::array<double, 2>> outline;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const auto [x, y] = polygon[k];
    const auto [u, v] = polygon[(k + 1) % polygon.size()];
    const int parts = static_cast<int>(std::ceil(std::hypot(u - x, v - y) / face - 1e-9));
    for (int p = 0; p < parts; ++p) outline.push_back({x + p * (u - x) / parts, y + p * (v - y) / parts});
  }
  const int count = static_cast<int>(outline.size()), layers = static_cast<int>(std::ceil(2 * half / face));
  const auto at = [&](int i, int layer) { return points + layer * count + i % count + 1; };
  for (int layer = 0; layer <= layers; ++layer)
    for (const auto& [x, y] : outline) text += fmt::format("v {} {} {}\n", x, y, half * (2.0 * layer / layers - 1));
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i < count; ++i)
      text += fmt::format("f {} {} {} {}\n", at(i, layer), at(i + 1, layer), at(i + 1, layer + 1), at(i, layer + 1));
  std::string front = "f", back = "f";
  for (int i = 0; i < count; ++i) {
    front += fmt::format(" {}", at(i, layers));
    back += fmt::format(" {}", at(count - 1 - i, 0));
  }
  text += front + '\n' + back + '\n';
  points += count * (layers + 1);
}

/// The text of an OBJ file: two legs of 30 × 60 × 80 mm with their faces at x = ±gap/2 (m), of one piece with what
/// joins them above y = 0. Legs that overlap, with a negative gap, are two pieces.
inline std::string two_legs(double gap) {
  constexpr double width = 0.03, length = 0.06, thick = 0.02, half = 0.04, face = 0.006;
  const double inner = 0.5 * gap, outer = inner + width;
  std::string text;
  int points = 0;
  if (gap > 0) {
    add_prism(text, points,
              {{-outer, -length},
               {-inner, -length},
               {-inner, 0},
               {inner, 0},
               {inner, -length},
               {outer, -length},
               {outer, thick},
               {-outer, thick}},
              half, face);
    return text;
  }
  add_prism(text, points, {{-outer, -length}, {-inner, -length}, {-inner, thick}, {-outer, thick}}, half, face);
  add_prism(text, points, {{inner, -length}, {outer, -length}, {outer, thick}, {inner, thick}}, half, face);
  return text;
}

}  // namespace drench::test
