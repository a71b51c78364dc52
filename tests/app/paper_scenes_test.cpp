// scenes/paper: they can be built, and they have the paper's numbers of particles and nodes (its Table 8) and its
// constants.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "paths.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench::test {
namespace {

struct Size {
  const char* name;
  double particles, nodes;
};
constexpr Size sizes[] = {{"low", 200800, 9022}, {"medium", 610048, 13978}, {"high", 800120, 23570}};
constexpr double tolerance = 0.005;  // 1

std::string paper_scene(const std::string& name) { return scenes_folder() + "/paper/" + name + ".yaml"; }

class paper_scenes : public testing::TestWithParam<std::string> {};

}  // namespace

TEST_P(paper_scenes, has_the_papers_counts_and_constants) {
  const std::string& name = GetParam();
  std::vector<std::string> overrides;
  if (name.starts_with("rotating_bunny")) {
    if (!std::filesystem::exists(scenes_folder() + "/../.deps/models/bunny.obj"))
      GTEST_SKIP() << "the mesh is not here: tools/measure/fetch-models fetches it";
    overrides = {"bodies.0.mesh.scale=0.05"};  // whose distance field takes a second, not a minute
  }
  const Scene scene = load_scene(paper_scene(name), overrides);
  const drench::Setup setup = build(scene);
  const Size& size =
      *std::find_if(std::begin(sizes), std::end(sizes), [&](const Size& s) { return name.ends_with(s.name); });
  EXPECT_NEAR(static_cast<double>(setup.state.fluid_count()), size.particles, tolerance * size.particles);
  EXPECT_NEAR(static_cast<double>(setup.model.mesh.nodes()), size.nodes, tolerance * size.nodes);

  // Δt is the paper's. Where the water hits the sheet at more than d/Δt, that is what there is to be said.
  const bool fast =
      name.starts_with("cloth_on_sphere") || (name.starts_with("side_injection") && !name.ends_with("low"));
  ASSERT_EQ(setup.warnings.size(), fast ? 1U : 0U) << (setup.warnings.empty() ? "" : setup.warnings.front());
  if (fast) {
    EXPECT_EQ(setup.warnings[0].find("time.step: particles at an impact"), 0U) << setup.warnings[0];
  }

  EXPECT_EQ(scene.time.mode, TimeMode::fixed);
  EXPECT_EQ(scene.time.step, 0.004);
  const double steps = scene.time.end / scene.time.step;
  EXPECT_NEAR(steps, name.starts_with("water_falling") ? 500 : 600, 1e-6);
  EXPECT_TRUE(scene.fluid.jets.empty()) << "the liquid is there from the start";
  for (const ClothScene& cloth : scene.cloths) {
    EXPECT_EQ(cloth.material.absorption, 0.01);
    EXPECT_EQ(cloth.material.max_saturation, 1.18);
    EXPECT_EQ(cloth.material.virtual_pressure, 16.8);
    EXPECT_EQ(cloth.material.emission_angle, 80);
  }
}

INSTANTIATE_TEST_SUITE_P(each, paper_scenes,
                         testing::Values("water_falling_low", "water_falling_medium", "water_falling_high",
                                         "side_injection_low", "side_injection_medium", "side_injection_high",
                                         "cloth_on_sphere_low", "cloth_on_sphere_medium", "cloth_on_sphere_high",
                                         "rotating_bunny_medium"),
                         [](const auto& each_of) { return each_of.param; });

TEST(paper_scenes_folder, holds_no_scene_that_is_not_looked_at) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scenes_folder() + "/paper"))
    scenes += entry.path().extension() == ".yaml";
  EXPECT_EQ(scenes, 10);
}

}  // namespace drench::test
