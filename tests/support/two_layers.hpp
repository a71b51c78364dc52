#pragma once
// Layers of cloth that touch.

#include <string>

namespace drench::test {

/// Two sheets one above the other that touch, turned and displaced against each other, the lower one wet on one side.
/// `lower` and `upper`: lines of these cloths besides, each with its indentation and its end.
inline std::string two_layers(const std::string& diffusion, const std::string& lower = "",
                              const std::string& upper = "") {
  return R"(drench: 1
time: {step: 0.01, end: 1.0}
cloth:
  - name: lower
    mesh: {grid: {size: [0.3, 0.2], nodes: [13, 9]}}
    dynamics: false
    thickness: 0.002
    initial_saturation: [{box: {min: [-1, -1, -1], max: [0.05, 1, 1]}, value: 1.15}]
    porous: {diffusivity: 1.0e-4, capillary_height: 0.1, contact_wicking: true, )" +
         diffusion + "}\n" + lower + R"(  - name: upper
    mesh: {grid: {size: [0.25, 0.25], nodes: [10, 11]}}
    place: {position: [0.03, 0.002, 0.01], rotate: {axis: [0, 1, 0], degrees: 20}}
    dynamics: false
    thickness: 0.001
    porous: {solid_fraction: 0.6, diffusivity: 3.0e-5, contact_wicking: true}
)" + upper;
}

}  // namespace drench::test
