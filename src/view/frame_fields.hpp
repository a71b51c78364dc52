#pragma once
// The fields of the frames that a picture can be coloured by.

#include <string>
#include <vector>

#include "view/run_frames.hpp"

namespace drench {

/// What everything looks like without a field: water is water, and cloth darkens and glosses with saturation.
inline constexpr const char* plain_look = "look";

struct FieldRange {
  std::string name;
  double low = 0, high = 0;  // of all but the outermost finite values; of the length, where it is a vector
};

/// "m/s", or "" for a number without a unit or a field that drench does not write.
std::string unit_of(const std::string& field);

/// The point fields of liquid, surface and cloth in these moments, in the order of the frames, each with its range over
/// all.
std::vector<FieldRange> field_ranges(const std::vector<Moment>& moments);

}  // namespace drench
