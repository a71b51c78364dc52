// Cloth whose nodes follow files: what liquid and air do to it between the cloth's own stages (docs/theory/cloth.md,
// 7).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "paths.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

constexpr int side = 9;

/// wet_scene() with viscosity, tension and wind, whose sheet follows files: it sags and sways.
std::string baked_scene() {
  const std::filesystem::path folder = own_file("baked_sheet");
  std::filesystem::create_directories(folder);
  for (int k = 0; k < 8; ++k) {
    std::ofstream out(folder / fmt::format("sheet_{:02d}.obj", k));
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const double x = 0.3 * i / (side - 1) - 0.15, z = 0.3 * j / (side - 1) - 0.15, t = 0.02 * k;
        out << fmt::format("v {:.9g} {:.9g} {:.9g}\n", x + 0.2 * t * z, -4 * t * t * std::cos(9 * x) * std::cos(9 * z),
                           z + 0.1 * t);
      }
    for (int i = 0; i + 1 < side; ++i)
      for (int j = 0; j + 1 < side; ++j) {
        const int a = i * side + j + 1;
        out << fmt::format("f {} {} {} {}\n", a, a + 1, a + side + 1, a + side);
      }
  }
  const std::string path = folder.string();
  std::string scene = with(wet_scene(), "grid: {size: [0.3, 0.3], nodes: [9, 9]}", "file: " + path + "/sheet_00.obj");
  scene = with(scene, "{edges: true}",
               "{box: {min: [-1, -1, -1], max: [1, 1, 1]}, sequence: \"" + path + "/sheet_*.obj\", fps: 50}");
  scene = with(scene, "  viscosity: 1.0e-3\n", "  viscosity: 1.0e-3\n  surface_tension: 0.8\n");
  scene = with(scene, "    thickness: 0.002\n", "    thickness: 0.002\n    clean: off\n    adhesion: 0.3\n");
  return scene + "wind: {velocity: [6, 1, -2]}\n";
}

TEST(baked_cloth_stages, change_its_velocity_as_in_the_reference) {
  const std::string scene = baked_scene();
  const auto compare = [&](Stage stage, const std::string& changes, auto&& prepare) {
    SCOPED_TRACE(name_of(stage));
    compare_stage({.stage = stage, .scene = scene, .prepare = prepare, .changes = changes});
  };
  const auto as_it_is = [](const Model&, HostState&) {};
  for (const Stage stage :
       {Stage::divergence, Stage::forces, Stage::surface_tension, Stage::wind, Stage::absorption, Stage::diffusion})
    compare(stage, "node_velocity", as_it_is);
  compare(Stage::advection, "node_velocity", [](const Model&, HostState& s) {
    for (Vec3& v : s.fluid_velocity) v[1] -= 4;
  });
  compare(Stage::cloth, "node_velocity node_pin_force", as_it_is);
  compare(Stage::pressure, "fluid_velocity node_pin_force", as_it_is);
  compare(Stage::emission, "node_velocity", [](const Model& m, HostState& s) { overfill(m, s, 20); });
}

TEST(baked_cloth_stages, turn_it_with_a_frame_as_in_the_reference) {
  compare_stage(
      {.stage = Stage::rotating_frame,
       .scene = baked_scene() + "rotating_frame: {axis: [0, 1, 0], degrees_per_second: [[0, 50], [0.2, 90]]}\n",
       .changes = "node_velocity"});
}

TEST(baked_cloth_stages, leave_the_nodes_of_other_pins_alone) {
  const drench::Setup setup = setup_from(baked_scene()), held = setup_from(wet_scene());
  for (Index n = 0; n < setup.model.mesh.nodes(); ++n) {
    EXPECT_TRUE(setup.model.mesh.pinned[static_cast<std::size_t>(n)] && !setup.model.mesh.is_fixed(n));
    EXPECT_EQ(held.model.mesh.is_fixed(n), held.model.mesh.pinned[static_cast<std::size_t>(n)] != 0);
  }
}

}  // namespace
}  // namespace drench::test
