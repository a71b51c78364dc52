#pragma once
// A start in intersection.

namespace drench::test {

/// A sheet through the middle of a sphere: half of its nodes start up to 5 cm inside. Nothing else drives it.
inline constexpr const char* sheet_inside_a_sphere = R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, 0]
cloth:
  - mesh: {grid: {size: [0.3, 0.3], nodes: [31, 31]}}
    place: {position: [0, 0.03, 0]}
    settle: 50
bodies:
  - sphere: {center: [0, 0, 0], radius: 0.08}
)";

}  // namespace drench::test
