// A cloth whose motion is finished: all of its nodes follow a sequence of files, and it takes up liquid.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "drench/drench.hpp"
#include "run_program.hpp"
#include "setup/build.hpp"
#include "state/mass_budget.hpp"

namespace drench::test {
namespace {

constexpr int side = 9, files = 51;
constexpr double fps = 250;  // a file per step

/// Where a node is in a file: a sheet that sways.
Vec3 swaying(int i, int j, int file) {
  const double t = file / fps, x = 0.2 * i / (side - 1) - 0.1, z = 0.2 * j / (side - 1) - 0.1;
  return {x + 0.02 * std::sin(10 * t), 0.01 * std::sin(20 * t + 15 * x), z};
}

/// A sheet whose nodes are where `place(i, j)` puts them.
template <class Place>
std::string sheet_of(const Place& place) {
  std::string text;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const Vec3 x = place(i, j);
      text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", x[0], x[1], x[2]);
    }
  for (int i = 0; i + 1 < side; ++i)
    for (int j = 0; j + 1 < side; ++j) {
      const int a = i * side + j + 1;
      text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + side + 1) + " " +
              std::to_string(a + side) + "\n";
    }
  return text;
}

std::string sheet(int file) {
  return sheet_of([&](int i, int j) { return swaying(i, j, file); });
}

/// A drop that falls onto a sheet, with the pins of the sheet.
Scene drop_on(const std::string& mesh, const std::string& pins) {
  return parse_scene(R"(drench: 1
time: {step: 0.004, end: 0.3}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.06, 0.03, -0.06], max: [0.06, 0.09, 0.06], velocity: [0, -1, 0]}
cloth:
  - mesh: {file: ")" + mesh +
                         R"("}
    clean: off
    areal_density: 0.2
    stretch: 300
    pin: [)" + pins + R"(]
    porous: {absorption: 0.02}
)",
                     "drop.yaml");
}

Vec3 momentum(const Model& m, const HostState& s) {
  Vec3 sum{0, 0, 0};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      sum[a] += m.quantum * static_cast<double>(s.fluid_mass[i]) * s.fluid_velocity[i][a];
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      sum[a] += (m.mesh.solid_mass[n] + m.quantum * static_cast<double>(s.node_liquid[n])) * s.node_velocity[n][a];
  }
  return sum;
}

TEST(baked_cloth, takes_up_as_much_as_cloth_that_moves_the_same_way_by_itself) {
  const TempFolder folder;
  const auto file = [&](int k) { return (folder.path() / fmt::format("sheet_{:02d}.obj", k)).string(); };
  const auto write = [&](int k, const HostState& s) {
    write_text(file(k),
               sheet_of([&](int i, int j) { return s.node_position[static_cast<std::size_t>(i * side + j)]; }));
  };
  write_text(file(0), sheet_of([](int i, int j) { return Vec3{0.025 * i - 0.1, 0, 0.025 * j - 0.1}; }));
  Simulation free(drop_on(file(0), "{nodes: [0, 8, 72, 80]}"));
  std::vector<double> taken;
  for (int k = 1; free.time() < 0.3 - 1e-9; ++k) {
    taken.push_back(static_cast<double>(free.step().mass_cloth));
    write(k, free.state());
  }
  Simulation baked(drop_on(file(0), "{box: {min: [-9, -9, -9], max: [9, 9, 9]}, fps: 250, sequence: \"" +
                                        (folder.path() / "sheet_*.obj").string() + "\"}"));
  for (const double expected : taken) {
    const double actual = static_cast<double>(baked.step().mass_cloth);
    if (expected < 0.1 * taken.back()) continue;
    EXPECT_NEAR(actual / expected, 1, 0.01) << baked.time();
  }
}

TEST(baked_cloth, gives_to_its_pins_what_the_liquid_gives_to_it) {
  const TempFolder folder;
  for (int k = 0; k < files; ++k) write_text(folder.path() / fmt::format("sheet_{:02d}.obj", k), sheet(k));
  const Scene scene = drop_on((folder.path() / "sheet_00.obj").string(),
                              "{box: {min: [-9, -9, -9], max: [9, 9, 9]}, fps: 250, sequence: \"" +
                                  (folder.path() / "sheet_*.obj").string() + "\"}");
  const Model model = build(scene).model;
  Simulation run(scene);
  HostState before = run.state();
  while (run.time() < 0.2 - 1e-9) {
    const Vec3 start = momentum(model, before);
    const double dt = run.step().dt;
    const HostState after = run.state();
    const Vec3 end = momentum(model, after);
    for (std::size_t a = 0; a < 3; ++a) {
      double force = 0, mass = 0, largest = 0;
      for (const Vec3& f : after.node_pin_force) force += f[a], largest += std::fabs(f[a]);
      for (const double m : model.mesh.solid_mass) mass += m;
      mass += model.quantum * static_cast<double>(liquid_budget(after));
      const double gained = dt * (force + mass * scene.gravity[a]);
      EXPECT_NEAR(end[a] - start[a], gained, 1e-4 * dt * (largest + 9.81 * mass)) << run.time() << " " << a;
    }
    before = after;
  }
}

TEST(baked_cloth, takes_up_liquid_along_its_way) {
  const TempFolder folder;
  for (int k = 0; k < files; ++k)
    write_text(folder.path() / ("sheet_" + std::string(k < 10 ? "0" : "") + std::to_string(k) + ".obj"), sheet(k));
  const std::string first = (folder.path() / "sheet_00.obj").string(), all = (folder.path() / "sheet_*.obj").string();
  Simulation run(parse_scene(R"(drench: 1
time: {step: 0.004, end: 0.2}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.06, 0.03, -0.06], max: [0.06, 0.09, 0.06]}
cloth:
  - mesh: {file: ")" + first + R"("}
    clean: off
    pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, sequence: ")" +
                                 all + R"(", fps: 250}]
    porous: {absorption: 0.05}
)",
                             "baked.yaml"));
  const Quanta mass = liquid_budget(run.state());
  StepReport last;
  while (run.time() < 0.2 - 1e-9) {
    last = run.step();
    EXPECT_EQ(last.cloth_residual, 0) << "there is nothing to solve";
  }
  const HostState state = run.state();
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_NEAR(state.node_position[static_cast<std::size_t>(i * side + j)][a], swaying(i, j, files - 1)[a], 3e-6);
  EXPECT_EQ(liquid_budget(state), mass);
  EXPECT_GT(static_cast<double>(last.mass_cloth), 0.01 * static_cast<double>(mass));
  double lift = 0;
  for (const Vec3& force : state.node_pin_force) lift += force[1];
  EXPECT_GT(lift, 0) << "it carries what it holds";
}

TEST(baked_cloth, does_not_go_on_with_other_files) {
  const TempFolder folder;
  const auto file = [&](int k) { return folder.path() / ("sheet_" + std::to_string(k) + ".obj"); };
  for (int k = 0; k < 12; ++k) write_text(file(k), sheet(k));
  const Scene scene = parse_scene(R"(drench: 1
time: {step: 0.004, end: 0.2}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
cloth:
  - mesh: {file: ")" + file(0).string() +
                                      R"("}
    clean: off
    pin: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, sequence: ")" +
                                      (folder.path() / "sheet_*.obj").string() + R"(", fps: 250}]
)",
                                  "baked.yaml");
  const std::string checkpoint = (folder.path() / "here.checkpoint").string();
  Simulation(scene).save_checkpoint(checkpoint);
  EXPECT_TRUE(Simulation(scene).resume(checkpoint).empty());
  write_text(file(7), sheet(8));  // of the same size
  try {
    Simulation(scene).resume(checkpoint);
    FAIL() << "another motion";
  } catch (const std::exception& e) {
    EXPECT_NE(std::string(e.what()).find("the files of a sequence have changed"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace drench::test
