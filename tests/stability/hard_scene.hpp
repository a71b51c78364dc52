#pragma once
// The scene that most hard cases start from: 144 particles just above a light porous sheet that is held along its
// edges.

#include <string>

#include "quanta_sum.hpp"
#include "stage_compare.hpp"
#include "watch.hpp"

namespace drench::test {

inline constexpr const char* water_over_sheet = R"(drench: 1
time: {step: 0.002, end: 10}
domain: {min: [-0.3, -0.3, -0.3], max: [0.3, 0.4, 0.3]}
fluid:
  spacing: 0.015
  viscosity: 1.0e-4
  sources: [{block: {min: [-0.045, 0.0075, -0.045], max: [0.045, 0.0675, 0.045]}}]
cloth:
  - name: sheet
    mesh: {grid: {size: [0.24, 0.24], nodes: [9, 9]}}
    areal_density: 0.2
    thickness: 0.001
    pin: [{edges: true}]
    porous: {diffusivity: 1.0e-4}
)";

inline constexpr const char* edge_pins = "    pin: [{edges: true}]\n";
inline constexpr const char* porous_key = "    porous: {diffusivity: 1.0e-4}\n";

/// The same with some of its text replaced.
inline std::string water_over(std::initializer_list<std::pair<const char*, std::string>> changes) {
  std::string scene = water_over_sheet;
  for (const auto& [from, to] : changes) scene = with(scene, from, to);
  return scene;
}

/// Water in a container of 0.12 m × 0.3 m × 0.12 m: `rest` begins with the sources.
inline std::string water_in_a_box(const std::string& rest) {
  return R"(drench: 1
time: {step: 0.002, end: 10}
bodies: [{box: {min: [-0.06, 0, -0.06], max: [0.06, 0.3, 0.06], inside: true}}]
fluid:
  spacing: 0.015
  viscosity: 1.0e-4
  sources:)" +
         rest;
}

}  // namespace drench::test
