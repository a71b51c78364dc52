// Cloth with regions: every stage that reads a material, backend against reference; the same bits on every run.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/run_program.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "two_layers.hpp"

namespace drench::test {
namespace {

/// Three regions and seams between them, one of which crosses cells.
constexpr const char* regions = R"(    regions:
      - {box: {min: [0.02, -1, -1], max: [1, 1, 1]}, areal_density: 0.5, thickness: 0.003, stretch: 1500, bend: 1.0e-3,
         damping: 4, friction: 0.8, porous: {solid_fraction: 0.6, absorption: 0.05, max_saturation: 1.4,
             diffusivity: 3.0e-3,
         virtual_pressure: 8, emission_angle: 60, emission_velocity: 2, critical_saturation: 0.6}}
      - {box: {min: [-0.04, -1, -0.06], max: [0.06, 1, 0.06]},
            porous: {solid_fraction: 0.2, uptake_velocity: 0.2, diffusivity: 2.0e-4}}
)";

std::string patched(const std::string& scene) { return with(scene, "    pin:", std::string(regions) + "    pin:"); }
std::string patched() { return patched(wet_scene()); }

/// With a membrane and, by pd, a plate, and a region of springs between those of the weave.
std::string woven(bool plate) {
  const std::string bending = plate ? "\n    bending: {warp: 2.0e-4, weft: 5.0e-5, twist: 1.0e-4}" : "";
  std::string scene =
      with(patched(), "thickness: 0.002\n",
           "thickness: 0.002\n    membrane: {warp: 800, weft: 300, shear: 60, wet: 0.5}\n    warp: [1, 0.2, 0.4]" +
               bending + "\n");
  scene =
      with(scene, "porous: {solid_fraction: 0.2,", "membrane: {warp: 3000, wet: 0.9}, porous: {solid_fraction: 0.2,");
  return plate ? with(scene, "bend: 1.0e-3", "bending: {warp: 2.0e-3}") : scene;
}

/// The same sheet as a mesh file whose faces have names.
std::string of_file(const TempFolder& folder) {
  constexpr int n = 9;
  std::string obj;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      obj +=
          fmt::format("v {} 0 {}\n", 0.3 * i / (n - 1) - 0.15 + (i % (n - 1) ? 0.006 * std::sin(7.0 * i + 3 * j) : 0),
                      0.3 * j / (n - 1) - 0.15 + (j % (n - 1) ? 0.006 * std::sin(5.0 * j + 11 * i) : 0));
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const int a = 1 + i + n * j;
      obj += fmt::format("g {}\nf {} {} {}\nf {} {} {}\n", i < 4 ? "left" : "right", a, a + n, a + 1, a + 1, a + n,
                         a + n + 1);
    }
  write_text(folder.path() / "two.obj", obj);
  return with(with(patched(), "grid: {size: [0.3, 0.3], nodes: [9, 9]}",
                   "file: \"" + (folder.path() / "two.obj").string() + "\""),
              "box: {min: [0.02, -1, -1], max: [1, 1, 1]}", "group: right");
}

void stir(const Model&, HostState& s) {
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
    const double k = double(n);
    s.node_velocity[n] = {std::sin(12.9898 * k + 1), 0.3 + std::sin(78.233 * k + 2), std::sin(37.719 * k + 3)};
  }
}

/// Taut, pins and all, so that the step has one solution.
void stretch(const Model&, HostState& s) {
  for (Vec3& x : s.node_position)
    x = {1.05 * x[0] + 0.08 * x[2], x[1] + 0.002 * std::cos(70 * x[2]), 1.06 * x[2] + 0.002 * std::sin(40 * x[0])};
}

std::string by_xpbd(const std::string& scene) {
  return with(scene, "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n");
}

/// Solved as far as the precision goes, so that other ways to the solution end at the same place.
std::string converged(const std::string& scene, const std::string& method) {
  return with(scene, "cloth:\n",
              fmt::format("cloth_solver: {{method: {}, tolerance: {}, max_iterations: 20000}}\ncloth:\n", method,
                          double_precision ? "1.0e-12" : "1.0e-6"));
}

}  // namespace

TEST(regions, cloth_agrees_with_the_reference) {
  compare_stage({.stage = Stage::cloth, .scene = patched(), .changes = "node_velocity"});
  compare_stage({.stage = Stage::cloth, .scene = by_xpbd(patched()), .changes = "node_velocity"});
}

/// Taut without solids, where the host factors its Hessian, and on the sphere.
TEST(regions, woven_cloth_agrees_with_the_reference) {
  for (const bool plate : {true, false}) {
    const std::string scene = converged(woven(plate), plate ? "pd" : "xpbd");
    compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
    compare_stage({.stage = Stage::cloth,
                   .scene = scene.substr(0, scene.find("bodies:")),
                   .prepare = stretch,
                   .changes = "node_velocity"});
  }
}

TEST(regions, groups_of_a_file_agree_with_the_reference) {
  const TempFolder folder;
  const std::string scene = of_file(folder);
  compare_stage({.stage = Stage::cloth, .scene = scene, .changes = "node_velocity"});
  compare_stage({.stage = Stage::diffusion, .scene = scene, .prepare = stir, .changes = "node_liquid node_velocity"});
  compare_stage({.stage = Stage::absorption, .scene = scene, .changes = "node_liquid"});
}

TEST(regions, diffusion_agrees_with_the_reference) {
  for (const char* keys : {"diffusion: linear", "diffusion: degenerate",
                           "diffusion_exponent: 2.5, retention_exponent: 1.5", "weft_diffusivity: 2.0e-4"}) {
    SCOPED_TRACE(keys);
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(patched(), "diffusivity: 1.0e-3", std::string("diffusivity: 1.0e-3, ") + keys),
                   .prepare = stir,
                   .changes = "node_liquid node_velocity"});
  }
}

TEST(regions, diffusion_agrees_where_nodes_are_full_or_empty) {
  compare_stage({.stage = Stage::diffusion,
                 .scene = with(patched(), "capillary_height: 0.3", "capillary_height: 0.01"),
                 .prepare =
                     [](const Model& m, HostState& s) {
                       for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
                         const double full = m.material_of_node(static_cast<Index>(n)).max_saturation *
                                             m.samples.node_capacity[n] / m.quantum;
                         s.node_liquid[n] = n % 3 == 0 ? 0 : static_cast<Quanta>(n % 3 == 1 ? full : 0.3 * full);
                       }
                     },
                 .changes = "node_liquid"});
}

TEST(regions, exchange_with_the_liquid_agrees_with_the_reference) {
  compare_stage({.stage = Stage::flow_direction, .scene = patched()});
  compare_stage({.stage = Stage::absorption, .scene = patched(), .changes = "node_liquid"});
  compare_stage({.stage = Stage::emission,
                 .scene = patched(),
                 .prepare = [](const Model& m, HostState& s) { overfill(m, s, 2); },
                 .changes = "node_liquid"});
}

TEST(regions, permeation_agrees_with_the_reference) {
  const std::string scene =
      with(with(patched(), "absorption: 0.02,", "absorption: 0.02, permeability: 1.0e-9,"), "absorption: 0.05,",
           "absorption: 0.05, permeability: 5.0e-9, breakthrough_pressure: 20,");
  compare_stage({.stage = Stage::permeation, .scene = scene});
  compare_stage({.stage = Stage::absorption, .scene = scene, .changes = "node_liquid"});
}

TEST(regions, drying_agrees_with_the_reference) {
  compare_stage({.stage = Stage::drying,
                 .scene = with(patched(), "fluid:", "air: {evaporation_rate: 0.5}\nfluid:"),
                 .changes = "node_liquid"});
}

TEST(regions, wind_agrees_with_the_reference) {
  compare_stage({.stage = Stage::wind,
                 .scene = with(patched(), "fluid:", "wind: {velocity: [3, 1, 2]}\nfluid:"),
                 .changes = "node_velocity"});
}

/// Two sheets that touch, each with a seam of its own across the other's.
TEST(regions, contact_wicking_agrees_with_the_reference) {
  const std::string scene = two_layers("diffusion: degenerate",
                                       "    regions: [{box: {min: [0, -1, -1], max: [1, 1, 1]}, thickness: 0.0015, "
                                       "porous: {diffusivity: 4.0e-4, solid_fraction: 0.7}}]\n",
                                       "    regions: [{box: {min: [-1, -1, 0.02], max: [1, 1, 1]}, thickness: 0.0025, "
                                       "porous: {diffusivity: 1.0e-5, max_saturation: 1.5}}]\n");
  compare_stage({.stage = Stage::diffusion, .scene = scene, .changes = "node_liquid"});
}

TEST(regions, adhesion_agrees_with_the_reference) {
  const std::string scene =
      with(with(patched(), "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  surface_tension: 0.05\n"), "friction: 0.8,",
           "friction: 0.8, adhesion: 0.06,");
  compare_stage({.stage = Stage::surface_tension, .scene = scene, .changes = "fluid_velocity node_velocity"});
}

TEST(regions, contact_agrees_with_the_reference) {
  const std::string scene = with(patched(), "    pin:", "    self_collision: true\n    pin:");
  const auto press = [](const Model& m, HostState& s) {
    for (Vec3& x : s.node_position) x[1] -= 0.0095;
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
      if (!m.mesh.pinned[n]) s.node_velocity[n] = {0.4, -0.5, 0.1};
  };
  compare_stage({.stage = Stage::self_collision, .scene = scene, .prepare = press});
  compare_stage({.stage = Stage::cloth, .scene = patched(), .prepare = press, .changes = "node_contact_force"});
}

}  // namespace drench::test
