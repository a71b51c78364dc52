// What `drench check` and `drench run` warn of: each mistake by itself, in one line; nothing for a scene that is sound.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "paths.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "setup/forecast.hpp"

namespace drench::testing {
namespace {

constexpr const char* sound = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.5, -0.2, -0.5], max: [0.5, 1, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.1, 0.4, -0.1], max: [0.1, 0.5, 0.1]}
    - jet: {center: [0.3, 0.5, 0.3], radius: 0.04, velocity: [0, -1, 0], end: 0.5}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.6, 0.6], nodes: [21, 21]}}
    place: {position: [0, 0.2, 0]}
    pin: [{corners: true}]
    porous: {}
bodies:
  - sphere: {center: [0, 0, 0], radius: 0.1}
  - plane: {point: [0, -0.1, 0], normal: [0, 1, 0]}
)";

using Lines = std::vector<std::string>;

Lines warnings_of(const std::string& yaml, const Lines& overrides = {}, int real_bytes = 4) {
  MemoryBudget budget;
  budget.real_bytes = real_bytes;
  return build(parse_scene(yaml, "scene.yaml", overrides), budget).warnings;
}

std::string without(const char* line) {
  std::string text = sound;
  const auto at = text.find(line);
  if (at == std::string::npos) throw std::runtime_error(std::string("no line ") + line);
  return text.erase(at, std::string(line).size() + 1);
}

/// One warning, with these words in it.
void expect_one(const Lines& lines, const std::string& words) {
  ASSERT_EQ(lines.size(), 1U) << words << ": " << (lines.empty() ? "none" : lines[0] + "\n" + lines.back());
  EXPECT_NE(lines[0].find(words), std::string::npos) << lines[0];
  EXPECT_EQ(lines[0].find('\n'), std::string::npos) << lines[0];
  EXPECT_LT(lines[0].size(), 300U) << lines[0];
}

TEST(Warnings, AreNoneForASoundScene) { EXPECT_EQ(warnings_of(sound), Lines()); }

TEST(Warnings, NameEachMistakeOnce) {
  struct Mistake {
    Lines overrides;
    const char* words;
  };
  const Mistake mistakes[] = {
      {{"fluid.sources.0.block.min=[-0.1, 0.195, -0.1]"},
       "100 of the blocks' particles start within 0.01 m of a cloth"},
      {{"bodies.0.sphere.center=[0, 0.45, 0]"},
       "particles removed: they start inside a solid body (block 0 in bodies.0)"},
      {{"fluid.sources=[{block: {min: [-0.1, 0.4, -0.1], max: [0.1, 0.5, 0.1]}},"
        " {block: {min: [0, 0.4, -0.1], max: [0.2, 0.5, 0.1]}}]"},
       "250 particles are omitted where blocks overlap (block 1 with an earlier one)"},
      {{"fluid.sources=[{block: {min: [-0.1, 0.4, -0.1], max: [0.1, 0.5, 0.1]}},"
        " {block: {min: [0.01, 0.41, -0.09], max: [0.09, 0.49, 0.09]}}]"},
       "144 particles start closer than 0.9 spacings to an earlier block's (block 1)"},
      {{"bodies.1={box: {min: [-0.145, 0.38, -0.2], max: [-0.095, 0.6, 0.2]}}"},
       "50 of the blocks' particles start closer than 0.4 spacings to a wall (block 0 at bodies.1)"},
      {{"bodies.1={box: {min: [-0.5, -0.11, -0.5], max: [0.5, -0.1, 0.5]}}"},
       "bodies.1: its thickness 0.01 m is 0.5 spacings"},
      {{"bodies.1={box: {min: [-0.5, -0.2, -0.5], max: [0.5, 0.99, 0.5], inside: true}}",
        "bodies.0.sphere.radius=0.03"},
       "bodies.0: its radius 0.03 m is 1.5 spacings"},
      {{"bodies.1={sphere: {center: [0, 0.13, 0], radius: 0.05, dynamic: true, density: 300}}"},
       "bodies.1: it starts 0.02 m inside bodies.0; pushing it out adds 0.031 J; move one of them"},
      {{"bodies.1={box: {min: [0, 0.05, 0], max: [0.1, 0.13, 0.1], dynamic: true, density: 300}}"},
       "bodies.1: it starts 0.05 m inside bodies.0; pushing it out adds 0.12 J; move one of them"},
      {{"cloth.0.mesh.grid.nodes=[4, 4]"}, "spacings: bending and wetting are much coarser than the liquid"},
      {{"cloth.0.mesh.grid={size: [0.3, 0.3], nodes: [76, 76]}"}, "11250 quadrature points, at least one per triangle"},
      {{"time.step=0.02"}, "spacings per step (CFL number"},
      {{"time.step=0.003"}, "output.every is 6.667 times time.step"},
      {{"domain={min: [-30, -0.2, -30], max: [30, 60, 30]}", "bodies=[{sphere: {center: [0, 0, 0], radius: 0.1}}]"},
       "domain: it has 3.4e+09 cells of the support radius 0.04 m, more than 2^31"},
      {{"domain={min: [-0.5, -0.2, -0.03], max: [0.5, 1, 0.03]}",
        "fluid.sources=[{block: {min: [-0.1, 0.4, -0.02], max: [0.1, 0.5, 0.02]}}]"},
       "domain: 0.06 m in z are 1.5 support radii"},
      {{"fluid.sources.1.jet.start=2", "fluid.sources.1.jet.end=3"},
       "jet 0: it starts at 2 s and the scene ends at 1 s: it never flows"},
      {{"fluid.sources.1.jet.center=[0.49, 0.5, 0.3]"}, "points of its mouth are outside the domain"},
      {{"fluid.sources.1.jet.center=[0.2, 0.205, 0.2]"},
       "points of its mouth are within 0.01 m, half a spacing, of a cloth"},
      {{"fluid.sources.1.jet.center=[0, 0.45, 0]"}, "points of its mouth are in a block's liquid"},
      {{"cloth.0.hold_saturation=[{box: {min: [-1, 0, -1], max: [0, 1, 1]}, value: 1}]", "processes={emission: off}",
        "cloth.0.porous.diffusivity=0"},
       "hold_saturation has no effect: porous.diffusivity is 0"},
      {{"cloth.0.porous={film: 3.0e-4, max_saturation: 1.5}"},
       "porous.max_saturation has no effect: porous.film sets it to 2"},
      {{"air.transfer_coefficient=0"}, "air: nothing evaporates: transfer_coefficient is 0"},
      {{"air.evaporation_rate=0"}, "air: nothing evaporates: evaporation_rate is 0"},
      {{"air.humidity=1"}, "air: nothing evaporates into air of humidity 1"},
      {{"cloth.0.hold_saturation=[{box: {min: [-1, 2, -1], max: [0, 3, 1]}, value: 1}]"},
       "hold_saturation: a box contains no node of the cloth"},
      {{"fluid.sources.0.block.concentration=1.0e-8", "fluid.sources.1.jet.concentration=0.5"},
       "block 0 has a concentration of 1e-08, the scene up to 0.5"},
      {{"cloth.0.initial_stain=[{box: {min: [-1, 2, -1], max: [0, 3, 1]}, value: 1}]"},
       "initial_stain: a box contains no node of the cloth"},
      {{"cloth.0.porous.diffusivity=1", "cloth.0.mesh.grid.nodes=[41, 41]"},
       "sub-steps per step; for 50 use a diffusivity of"},
      {{"fluid.viscosity=100"}, "fluid: viscosity needs about"},
      {{"fluid.drains=[{box: {min: [-0.1, -0.1, -0.1], max: [0.1, -0.095, 0.1]}}]"},
       "fluid.drains.0: it is 0.005 m thick, less than a particle, 0.02 m"},
      {{"fluid.drains=[{sphere: {center: [0, 0.3, 0], radius: 0.009}}]"}, "fluid.drains.0: it is 0.018 m thick"},
      {{"fluid.drains=[{box: {min: [0.6, 0, 0], max: [0.8, 1, 1]}}]"}, "fluid.drains.0: it is outside the domain"},
      {{"fluid.drains=[{sphere: {center: [0, 1.2, 0], radius: 0.1}}]"}, "fluid.drains.0: it is outside the domain"},
      {{"fluid.drains=[{plane: {point: [0, -0.3, 0], normal: [0, 1, 0]}}]"},
       "fluid.drains.0: it is outside the domain"},
      {{"output.probes=[{name: H1, point: {position: [0, 2, 0]}}]"}, "probe 'H1': it is outside the domain"},
      {{"output.probes=[{name: H2, line: {from: [1, 0, 0], to: [1, 1, 0]}}]"}, "probe 'H2': it is outside the domain"},
      {{"output.probes=[{name: Q, disc: {center: [0, 2, 0], normal: [0, 1, 0], radius: 0.1}}]"},
       "probe 'Q': it is outside the domain"},
      {{"bodies.0={sphere: {center: [0.2, 0.3, 0], radius: 0.06, dynamic: true, density: 300}}",
        "bodies.1={box: {min: [0.2, 0.29, -0.1], max: [0.35, 0.4, 0.1], dynamic: true, density: 300}}"},
       "bodies.0: it starts 0.06 m inside bodies.1; they are pushed apart at once; move one of them"},
  };
  for (const Mistake& m : mistakes) {
    SCOPED_TRACE(m.overrides[0]);
    expect_one(warnings_of(sound, m.overrides), m.words);
  }
}

TEST(Warnings, AreWithheldWhereTheSameIsNoMistake) {
  EXPECT_EQ(warnings_of(sound, {"time.step=0.02", "time.mode=cfl"}), Lines());
  EXPECT_EQ(warnings_of(sound, {"fluid.wall_pressure=mirrored"}), Lines());
  EXPECT_EQ(warnings_of(sound, {"fluid.drains=[{plane: {point: [0, -0.15, 0], normal: [0, 1, 0]}}, {sphere: {center: "
                                "[0, 1.2, 0], radius: 0.3}}]",
                                "output.probes=[{name: H, line: {from: [0, -0.5, 0], to: [0, 2, 0]}}]"}),
            Lines());
  EXPECT_EQ(warnings_of(sound, {"bodies.1={name: b, sphere: {center: [0.2, 0.3, 0], radius: 0.06, dynamic: true, "
                                "density: 300}}",
                                "bodies.0={name: a, sphere: {center: [0.2, 0.4, 0], radius: 0.06, dynamic: true, "
                                "density: 300}}",
                                "joints=[{hinge: {body: a, to: b, point: [0.2, 0.35, 0], axis: [1, 0, 0]}}]"}),
            Lines());
  EXPECT_EQ(warnings_of(sound, {"cloth.0.hold_saturation=[{box: {min: [-1, 0, -1], max: [0, 1, 1]}, value: 1}]",
                                "processes={emission: off}"}),
            Lines());
  // A domain of which a container leaves little, at any size; there the liquid stays.
  EXPECT_EQ(warnings_of(sound, {"domain={min: [-30, -0.3, -30], max: [30, 60, 30]}",
                                "bodies=[{box: {min: [-0.5, -0.2, -0.5], max: [0.5, 1, 0.5], inside: true}}]"}),
            Lines());
}

TEST(Warnings, SeeAClothThatNothingHolds) {
  const std::string loose = without("    pin: [{corners: true}]");
  EXPECT_EQ(warnings_of(loose, {"time.end=5"}), Lines()) << "it falls on the sphere";
  EXPECT_EQ(warnings_of(loose, {"time.end=5", "bodies=[{plane: {point: [0, -0.1, 0], normal: [0.1, 1, 0]}}]"}),
            Lines());
  const std::string bare = loose.substr(0, loose.find("bodies:"));
  expect_one(warnings_of(bare, {"time.end=5"}), "cloth 'sheet': it has no pins and nothing lies under it");
  EXPECT_EQ(warnings_of(bare, {"time.end=0.2"}), Lines()) << "it does not come that far";
  EXPECT_EQ(warnings_of(bare, {"time.end=5", "gravity=[0, 0, 0]"}), Lines());
  EXPECT_EQ(warnings_of(bare, {"time.end=5", "cloth.0.dynamics=false"}), Lines());
}

TEST(Warnings, KnowThePrecision) {
  const std::string far =
      "drench: 1\ntime: {step: 0.002, end: 1}\ndomain: {min: [4999, -1, -1], max: [5001, 1, 1]}\n"
      "fluid: {spacing: 0.02, sources: [{block: {min: [4999.9, 0, 0], max: [5000, 0.1, 0.1]}}]}\n";
  expect_one(warnings_of(far), "rounded to 0.0006 m, 0.03 of a spacing");
  EXPECT_EQ(warnings_of(far, {}, 8), Lines());
}

TEST(Warnings, AreNoneForTheScenesOfTheProject) {
  int scenes = 0;
  for (const auto& file : std::filesystem::directory_iterator(test::scenes_folder())) {
    if (file.path().extension() != ".yaml") continue;
    EXPECT_EQ(build(load_scene(file.path())).warnings, Lines()) << file.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 14);  // paper_scenes looks at the paper's
}

/// Falls from rest at the uppermost particles of a block, 0.99 m high.
TEST(Forecast, FollowsTheLiquidToWhatItHits) {
  const std::string drop =
      "drench: 1\ntime: {end: 2}\ndomain: {min: [-1, -1, -1], max: [1, 2, 1]}\n"
      "fluid: {spacing: 0.02, sources: [{block: {min: [0, 0.8, 0], max: [0.2, 1, 0.2]}}]}\n";
  const auto speeds = [](const std::string& yaml) {
    const drench::Setup setup = build(parse_scene(yaml, "scene.yaml"));
    return expected_speeds(setup.model, setup.state);
  };
  const auto after = [](double height) { return std::sqrt(2 * 9.81 * height); };
  const ExpectedSpeeds nothing = speeds(drop);
  EXPECT_EQ(nothing.impact, 0) << "nothing is hit";
  EXPECT_NEAR(nothing.fastest, after(1.99), 0.2);
  const ExpectedSpeeds floor = speeds(drop + "bodies: [{plane: {point: [0, 0, 0], normal: [0, 1, 0]}}]\n");
  EXPECT_NEAR(floor.impact, after(0.98), 0.1);
  EXPECT_NEAR(floor.fastest, floor.impact, 0.1) << "the floor ends the fall";
  const ExpectedSpeeds ball = speeds(drop + "bodies: [{sphere: {center: [0.1, 0.2, 0.1], radius: 0.15}}]\n");
  EXPECT_NEAR(ball.impact, after(0.64), 0.15);
  EXPECT_NEAR(ball.fastest, after(1.99), 0.2) << "it flows round the ball and falls on";
  const ExpectedSpeeds sheet = speeds(
      drop +
      "cloth: [{mesh: {grid: {size: [2, 2], nodes: [41, 41]}}, place: {position: [0, 0.5, 0]}, dynamics: false}]\n");
  EXPECT_NEAR(sheet.impact, after(0.49 - 0.025), 0.2);
  EXPECT_NEAR(sheet.fastest, sheet.impact, 0.2);
  // Towards a centre with Ω = 10/s from 0.95 m on: at it Ω times the distance, whatever gravity adds.
  const ExpectedSpeeds drawn = speeds(drop + "gravity: [0, 0, 0]\nfield: {center: [0.1, 0, 0.1], rate: [0, 10, 0]}\n");
  EXPECT_NEAR(drawn.fastest, 10 * 0.99, 0.2);
  const ExpectedSpeeds pushed =
      speeds(drop + "bodies: [{sphere: {center: [0, -0.5, 0], radius: 0.1, velocity: [7, 0, 0]}}]\n");
  EXPECT_NEAR(pushed.impact, 7, 1e-9);
}

TEST(Warnings, ClothTooStiffForItsSolver) {
  const std::string sheet =
      "drench: 1\ntime: {step: 0.002, end: 1}\ncloth_solver: {max_iterations: 300}\n"
      "cloth: [{mesh: {grid: {size: [0.09, 0.09], nodes: [7, 7]}}, pin: [{corners: true}], areal_density: 0.2,"
      " stretch: 500, strain_damping: 0.05}]\n";
  expect_one(warnings_of(sheet), "iterations per step, more than cloth_solver.max_iterations, 300");
  expect_one(warnings_of(sheet), "or less strain_damping");
  EXPECT_EQ(warnings_of(sheet, {"cloth.0.strain_damping=0"}), Lines());
  expect_one(warnings_of(sheet), "a time.step of 0.00091 s");
  EXPECT_EQ(warnings_of(sheet, {"time.step=0.00091", "output.every=0"}), Lines());
  expect_one(warnings_of(sheet, {"cloth.0.strain_damping=0", "cloth.0.stretch=0.01", "cloth.0.bend=1"}),
             "or less bend");
  EXPECT_EQ(warnings_of(sheet, {"cloth_solver.max_iterations=600"}), Lines());
  EXPECT_EQ(warnings_of(sheet, {"cloth.0.dynamics=false"}), Lines());
  expect_one(warnings_of(sheet, {"cloth.0.strain_damping=0", "cloth.0.stretch=50000"}), "or less stretch");
}

/// A cloth far finer than the liquid has all its samples in each neighbourhood.
TEST(Warnings, StrainLimitsTakeXpbdLonger) {
  const std::string sheet =
      "drench: 1\ntime: {step: 0.004, end: 1}\ncloth_solver: {method: xpbd}\n"
      "cloth: [{mesh: {grid: {size: [0.6, 0.6], nodes: [21, 21]}}, pin: [{corners: true}], stretch: 2000, "
      "strain_limit: 0.1}]\n";
  expect_one(warnings_of(sheet), "with xpbd, a cloth at its strain_limit needs at least");
  EXPECT_EQ(warnings_of(sheet, {"cloth_solver.method=pd"}), Lines());
  EXPECT_EQ(warnings_of(sheet, {"cloth.0.strain_limit=0"}), Lines());
  EXPECT_EQ(warnings_of(sheet, {"cloth_solver.max_iterations=20000"}), Lines());
}

TEST(MemoryEstimate, CountsNeighbours) {
  const drench::Setup setup = build(parse_scene(
      "drench: 1\nfluid:\n  spacing: 0.1\n  sources: [{block: {min: [-0.5, 0.1, -0.5], max: [0.5, 0.5, 0.5]}}]\n"
      "cloth: [{mesh: {grid: {size: [0.12, 0.12], nodes: [61, 61]}}}]\n",
      "scene.yaml"));
  const SetupSize size = size_of(setup);
  EXPECT_EQ(size.samples, 7200);
  EXPECT_EQ(size.entries.sample_sample.own, 7199) << "all of them are within 0.2 m of each other";
  double pairs = 0;
  for (const Vec3& x : setup.state.fluid_position) {
    for (const Vec3& y : setup.model.samples.rest_position)
      pairs += std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]) < setup.model.support ? 1 : 0;
  }
  const double mean = pairs / size.fluid;
  EXPECT_GT(mean, 10);
  EXPECT_NEAR(size.entries.fluid_sample.own, mean, 1e-9 * mean);
  EXPECT_GT(size.entries.fluid_sample.bundled, 1.5 * mean) << "most particles of a bundle have none";
}

}  // namespace
TEST(Warnings, AreNoneForASaturationThatAFilmJustHolds) {
  // 1 + 2 · 2.4e-4/0.6e-3 is rounded to less than 1.8.
  const Lines lines = warnings_of(sound, {"cloth.0.porous.film=2.4e-4",
                                          "cloth.0.initial_saturation=[{box: {min: [-1, -1, -1], max: [1, 1, 1]}, "
                                          "value: 1.8}]"});
  EXPECT_TRUE(lines.empty()) << lines.front();
}

}  // namespace drench::testing
