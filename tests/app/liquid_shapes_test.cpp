// Liquid that is there at the start in other shapes than boxes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>

#include "drench/drench.hpp"
#include "mesh_folder.hpp"
#include "setup/build.hpp"
#include "setup/setup_error.hpp"
#include "state/mass_budget.hpp"

namespace drench::test {
namespace {

Scene with_source(const std::string& source, const std::string& more = "") {
  return parse_scene(
      "drench: 1\ndomain: {min: [-1, -1, -1], max: [1, 1, 1]}\ntime: {step: 0.002, end: 1}\n"
      "fluid:\n  spacing: 0.02\n  sources:\n    - " +
          source + "\n" + more,
      "shapes.yaml");
}

using LiquidShapes = drench::testing::MeshFolder;

/// kg
double mass_of(const drench::Setup& setup) {
  return static_cast<double>(sum_of(setup.state.fluid_mass)) * setup.model.quantum;
}

/// A cube of side 1 around the origin, turned outwards.
const char* const cube = R"(v -0.5 -0.5 -0.5
v 0.5 -0.5 -0.5
v 0.5 0.5 -0.5
v -0.5 0.5 -0.5
v -0.5 -0.5 0.5
v 0.5 -0.5 0.5
v 0.5 0.5 0.5
v -0.5 0.5 0.5
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 2 3 7 6
f 4 1 5 8
)";

TEST_F(LiquidShapes, a_sphere_holds_density_times_volume_and_lies_evenly) {
  for (const double radius : {0.03, 0.0513, 0.1, 0.157}) {
    const drench::Setup setup = build(
        with_source("sphere: {center: [0.01, 0, 0], radius: " + std::to_string(radius) + ", velocity: [0, -1, 0]}"));
    const double volume = 4.0 / 3 * std::numbers::pi * radius * radius * radius;
    EXPECT_NEAR(mass_of(setup), 1000 * volume, 1e-9 * 1000 * volume) << radius;
    const auto [least, most] = std::minmax_element(setup.state.fluid_mass.begin(), setup.state.fluid_mass.end());
    EXPECT_LE(*most - *least, 1);
    Vec3 middle{0, 0, 0};
    for (const Vec3& x : setup.state.fluid_position) {
      const double r = std::hypot(x[0] - 0.01, x[1], x[2]);
      EXPECT_LT(r, radius + 0.005);
      for (std::size_t a = 0; a < 3; ++a) middle[a] += x[a] / static_cast<double>(setup.state.fluid_position.size());
    }
    EXPECT_NEAR(middle[0], 0.01, 1e-12) << "as symmetric as the sphere";
    EXPECT_NEAR(middle[1], 0, 1e-12);
    EXPECT_EQ(setup.state.fluid_velocity.front(), (Vec3{0, -1, 0}));
  }
}

TEST_F(LiquidShapes, a_mesh_that_is_a_box_gives_the_block) {
  const std::string file = write("cube.obj", cube);
  const drench::Setup mesh =
      build(with_source("mesh: {file: " + file + ", scale: 20, unit: cm, position: [0.1, 0.1, 0.1]}"));
  const drench::Setup block = build(with_source("block: {min: [0, 0, 0], max: [0.2, 0.2, 0.2]}"));
  ASSERT_EQ(mesh.state.fluid_position.size(), 1000u);
  for (std::size_t i = 0; i < 1000; ++i)
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(mesh.state.fluid_position[i][a], block.state.fluid_position[i][a], 1e-12);
  EXPECT_EQ(mesh.state.fluid_mass, block.state.fluid_mass);
}

TEST_F(LiquidShapes, a_turned_mesh_holds_its_mass) {
  const std::string file = write("cube.obj", cube);
  const drench::Setup setup = build(with_source(
      "mesh: {file: " + file + ", scale: 0.25, rotate: {axis: [1, 2, 3], degrees: 40}, concentration: 0.1}"));
  EXPECT_NEAR(mass_of(setup), 1000 * std::pow(0.25, 3), 1e-8);
  EXPECT_EQ(setup.state.fluid_solute.size(), setup.state.fluid_mass.size());
  EXPECT_GT(setup.state.fluid_solute.front(), 0);
}

TEST_F(LiquidShapes, particles_of_a_file_start_where_they_are) {
  const std::string file = write("drops.ply", R"(ply
format ascii 1.0
element vertex 2
property float x
property float y
property float z
property float vx
property float vy
property float vz
property float mass
end_header
0 0 10 1 2 3 0.008
4 5 6 0 0 -1 0.004
)");
  const drench::Setup setup = build(with_source("particles: {file: " + file + ", unit: cm, up: z}"));
  ASSERT_EQ(setup.state.fluid_position.size(), 2u);
  const double expected[2][3] = {{0, 0.1, 0}, {0.04, 0.06, -0.05}};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(setup.state.fluid_position[i][a], expected[i][a], 1e-7);
  EXPECT_NEAR(setup.state.fluid_velocity[0][1], 0.03, 1e-9);
  EXPECT_NEAR(setup.state.fluid_velocity[0][2], -0.02, 1e-9);
  EXPECT_NEAR(mass_of(setup), 0.012, 1e-8);
}

/// A cube of 8³ particles 0.02 m apart, each `copies` times; `spacing` of the scene.
TEST_F(LiquidShapes, particles_of_another_spacing_are_warned_of) {
  const auto warning = [&](double spacing, int copies, double mass, bool sequence) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
        "z\n{}end_header\n",
        512 * copies, mass > 0 ? "property float mass\n" : "");
    for (int k = 0; k < 512 * copies; ++k)
      text += fmt::format("{} {} {} {}\n", 0.02 * (k % 8), 0.02 * (k / 8 % 8), 0.02 * (k / 64 % 8),
                          mass > 0 ? fmt::format("{}", mass) : "");
    const std::string file = write("cube.ply", text);
    Scene scene = with_source(sequence ? "particles: {sequence: [" + file + ", " + file + "]}"
                                       : "particles: {file: " + file + "}");
    scene.fluid.spacing = spacing;
    std::string found;
    for (const std::string& line : build(scene).warnings)
      if (line.find("spacing " + fmt::format("{:g}", spacing)) != std::string::npos) found = line;
    return found;
  };
  for (const bool sequence : {false, true}) {
    EXPECT_EQ(warning(0.02, 1, 0, sequence), "");
    EXPECT_EQ(warning(0.04, 1, 0.008, sequence), "") << "an eighth of a full particle each";
    EXPECT_EQ(
        warning(0.04, 1, 0, sequence),
        "fluid: particle source 0: its particles are 0.5 times as far apart (median) as spacing 0.04 m and their "
        "masses require, so the liquid has 8 times its density; set spacing to the distance in the file, or write "
        "masses");
    EXPECT_NE(warning(0.01, 1, 0, sequence).find("are 2 times as far apart"), std::string::npos);
    EXPECT_NE(warning(0.02, 2, 0, sequence).find("100 % of the particles are closer to another one than half of"),
              std::string::npos);
  }
}

TEST_F(LiquidShapes, frames_of_a_run_start_another_one) {
  Simulation run(with_source("sphere: {center: [0, 0, 0], radius: 0.06}"));
  run.record((folder_ / "out").string());
  for (int k = 0; k < 5; ++k) run.step();
  run.end_record();
  std::filesystem::create_directory(folder_ / "mine");
  write("mine/note.txt", "");
  for (const bool overwrite : {false, true}) {
    try {
      run.record((folder_ / "mine").string(), overwrite);
      FAIL() << "written into a folder of something else";
    } catch (const std::runtime_error& e) {  // a program has no options of a command
      EXPECT_NE(std::string(e.what()).find("choose another folder"), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find(" -"), std::string::npos) << e.what();
    }
  }
  const HostState before = run.state();
  std::string last;
  for (const auto& entry : std::filesystem::directory_iterator((folder_ / "out").string() + "/frames"))
    if (const std::string name = entry.path().string(); name.find("fluid_") != std::string::npos)
      last = std::max(last, name);
  const drench::Setup next = build(with_source("particles: {file: " + last + "}"));
  ASSERT_EQ(next.state.fluid_position.size(), before.fluid_position.size());
  double fastest = 0;
  for (const Vec3& v : next.state.fluid_velocity) fastest = std::max(fastest, std::hypot(v[0], v[1], v[2]));
  EXPECT_NEAR(fastest, 0.002 * 5 * 9.81, 0.02) << "of free fall";
  EXPECT_NEAR(mass_of(next), static_cast<double>(sum_of(before.fluid_mass)) * run.quantum(), 1e-6);
}

TEST_F(LiquidShapes, liquid_in_a_round_vessel_starts_at_rest) {
  // The same sphere is the vessel and, half a spacing smaller, full of water. The bare lattice has 1.0 m/s in step 1.
  std::string sphere;
  const int rings = 16, parts = 32;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < parts; ++j) {
      const double theta = std::numbers::pi * i / rings, phi = 2 * std::numbers::pi * j / parts;
      sphere += "v " + std::to_string(0.15 * std::sin(theta) * std::cos(phi)) + " " +
                std::to_string(0.15 * std::cos(theta)) + " " + std::to_string(0.15 * std::sin(theta) * std::sin(phi)) +
                "\n";
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < parts; ++j) {
      const int a = i * parts + j + 1, b = i * parts + (j + 1) % parts + 1;
      sphere += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(b + parts) + " " +
                std::to_string(a + parts) + "\n";
    }
  const std::string file = write("ball.obj", sphere);
  Simulation run(with_source("mesh: {file: " + file + ", scale: 0.93}",
                             "gravity: [0, 0, 0]\nbodies:\n  - mesh: {file: " + file + ", inside: true}\n"));
  const Quanta mass = liquid_budget(run.state());
  double fastest = 0;
  for (int k = 0; k < 50; ++k) fastest = std::max(fastest, run.step().fluid_speed);
  EXPECT_LT(fastest, 0.3);
  EXPECT_EQ(liquid_budget(run.state()), mass);
  EXPECT_EQ(run.state().drained, 0);
}

TEST_F(LiquidShapes, a_mesh_in_another_unit_gets_a_hint_with_its_error) {
  const std::string file = write("cube.obj", cube);
  const std::string text =
      refusal_of([&] { build(with_source("mesh: {file: " + file + ", scale: 100}")); });  // as of millimetres
  EXPECT_NE(
      text.find("fluid: mesh source 0 is 100 m long: if the file is in centimetres, add unit: cm (1 m); if the file is "
                "in millimetres, add unit: mm (0.1 m) ("),
      std::string::npos)
      << text;
}

TEST_F(LiquidShapes, rain_has_its_rate_its_speed_and_covers_its_rectangle) {
  Scene scene = with_source("rain: {center: [0.1, 0.5, 0], size: [0.4, 0.2], rate: 20000, diameter: 0.003}");
  Simulation run(scene);
  run.step();
  const double speed = 9.65 - 10.3 * std::exp(-0.6 * 3);
  run.run_until(0.05);
  HostState state = run.state();
  ASSERT_GT(state.fluid_position.size(), 4u);
  EXPECT_NEAR(state.fluid_velocity.back()[1], -speed, 0.05) << "fell for less than a step";
  run.reset();
  Quanta supplied = 0;
  std::array<int, 4> quarter{};
  std::int64_t seen = 0;
  while (run.time() < 0.4) {
    run.step();
    state = run.state();
    for (std::size_t i = 0; i < state.fluid_id.size(); ++i) {
      if (state.fluid_id[i] < seen) continue;
      const Vec3& x = state.fluid_position[i];
      EXPECT_TRUE(std::abs(x[0] - 0.1) <= 0.2 && std::abs(x[2]) <= 0.1);
      ++quarter[static_cast<std::size_t>((x[0] > 0.1 ? 1 : 0) + (x[2] > 0 ? 2 : 0))];
    }
    seen = state.next_id;
    supplied = state.supplied;
  }
  const double kilograms = static_cast<double>(supplied) * run.quantum(),
               expected = 20.0 / 3600 * 0.08 * 1000 * run.time();
  EXPECT_NEAR(kilograms, expected, static_cast<double>(state.fluid_mass.front()) * run.quantum());
  EXPECT_GE(static_cast<double>(state.fluid_mass.front()), 0.125 * static_cast<double>(quanta_per_particle));
  for (const int count : quarter) EXPECT_NEAR(count, static_cast<double>(seen) / 4, 4);
}

TEST_F(LiquidShapes, the_rectangle_of_rain_lies_across_gravity) {
  const auto spans = [](const std::string& gravity) {
    const drench::Setup setup = build(
        with_source("rain: {center: [0, 0, 0], size: [0.4, 0.2], diameter: 0.004}", "gravity: " + gravity + "\n"));
    Vec3 most{0, 0, 0};
    for (const Vec3& offset : setup.model.jets.at(0).offsets)
      for (std::size_t a = 0; a < 3; ++a) most[a] = std::max(most[a], std::abs(offset[a]));
    for (double& side : most) side = std::round(100 * side) / 100;
    return most;
  };
  EXPECT_EQ(spans("[0, -9.81, 0]"), (Vec3{0.2, 0, 0.1}));
  EXPECT_EQ(spans("[0, 0, -9.81]"), (Vec3{0.2, 0.1, 0}));
  EXPECT_EQ(spans("[9.81, 1, 0]"), (Vec3{0, 0.2, 0.1}));
}

TEST_F(LiquidShapes, refuses_what_holds_no_liquid) {
  const std::string sheet = write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string text = write("drops.txt", "0 0 0\n");
  const auto refused = [](const std::string& source, const std::string& with) {
    try {
      build(with_source(source));
      ADD_FAILURE() << source;
    } catch (const SetupError& e) {
      EXPECT_NE(std::string(e.what()).find(with), std::string::npos) << e.what();
      EXPECT_EQ(e.key, "fluid.sources");
    }
  };
  refused("mesh: {file: " + sheet + "}", "encloses no volume");
  refused("particles: {file: " + text + "}", "allowed: .ply, .vtu, .vtp");
  refused("sphere: {center: [0, 0, 0], radius: 0.005}", "less than a particle's");
  refused("sphere: {center: [0, 0, 0], radius: 1.5}", "outside the domain");
}

}  // namespace
}  // namespace drench::test
