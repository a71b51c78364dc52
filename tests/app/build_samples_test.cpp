// From a scene to a model: samples, pins and saturation of cloth. Its mesh: build_test.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/eigen_vec.hpp"
#include "build_scenes.hpp"

namespace drench::testing {
namespace {

TEST(BuildSamples, WeightsAreasAndCapacitiesAddUp) {
  Scene scene = cloth_scene();
  scene.fluid.present = true;
  scene.fluid.spacing = 0.012;  // cuts the triangles into 3² each
  const Model m = build(scene).model;
  const SampleSet& s = m.samples;
  EXPECT_EQ(s.count(), 9 * m.mesh.triangles());
  EXPECT_NEAR(sum(s.area), 0.15, 1e-14);
  const double full = 0.6 * 0.15 * 0.001 * 1000;
  EXPECT_NEAR(sum(s.capacity) / full, 1, 1e-12);
  EXPECT_NEAR(sum(s.node_capacity) / full, 1, 1e-12);
  EXPECT_NEAR(sum(s.node_weight_sum), s.count(), 1e-9);
  for (std::size_t p = 0; p < s.triangle.size(); ++p) {
    EXPECT_NEAR(s.weight[p][0] + s.weight[p][1] + s.weight[p][2], 1, 1e-15);
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(s.weight[p][c], 0);
      const Index n = m.mesh.triangle[static_cast<std::size_t>(s.triangle[p])][c];
      x += s.weight[p][c] * to_eigen(m.mesh.rest_position[static_cast<std::size_t>(n)]);
    }
    EXPECT_LT((x - to_eigen(s.rest_position[p])).norm(), 1e-15);
  }
  // The samples' first moment is the triangle's: a linear field is sampled without bias.
  for (Index t = 0; t < m.mesh.triangles(); ++t) {
    double w0 = 0;
    for (int p = 0; p < 9; ++p) w0 += s.weight[static_cast<std::size_t>(9 * t + p)][0];
    EXPECT_NEAR(w0, 3, 1e-12);
  }
}

TEST(BuildSamples, CoverRadiusHoldsForRandomPoints) {
  Scene scene = cloth_scene({0.5, 0.2}, {4, 5});
  scene.fluid.present = true;
  scene.fluid.spacing = 0.02;
  const Model m = build(scene).model;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const auto t = static_cast<Index>(trial % m.mesh.triangles());
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& n = m.mesh.triangle[static_cast<std::size_t>(t)];
    const auto at = [&](int c) { return to_eigen(m.mesh.rest_position[static_cast<std::size_t>(n[c])]); };
    const Eigen::Vector3d x = at(0) + u * (at(1) - at(0)) + v * (at(2) - at(0));
    double nearest = 1;
    for (std::size_t p = 0; p < m.samples.triangle.size(); ++p) {
      if (m.samples.triangle[p] == t) nearest = std::min(nearest, (x - to_eigen(m.samples.rest_position[p])).norm());
    }
    worst = std::max(worst, nearest);
  }
  EXPECT_LE(worst, m.samples.cover_radius);
  EXPECT_GT(worst, 0.8 * m.samples.cover_radius);
}

TEST(BuildSamples, SpacingOfACloth) {
  Scene scene = cloth_scene();
  scene.fluid.present = true;
  scene.fluid.spacing = 0.012;
  const Model usual = build(scene).model;
  scene.cloths[0].sample_spacing = 0.0061;
  const Model fine = build(scene).model;
  EXPECT_EQ(fine.samples.count(), 4 * usual.samples.count());
  EXPECT_NEAR(fine.samples.spacing, usual.samples.spacing / 2, 1e-15);
  EXPECT_NEAR(fine.most_stretch(), 2 * usual.most_stretch(), 1e-12);
  EXPECT_GE(usual.most_stretch(), 1.5);
  EXPECT_NEAR(sum(fine.samples.capacity), sum(usual.samples.capacity), 1e-14);
}

TEST(BuildSamples, AreBuiltOnlyWhereNeeded) {
  Scene scene = cloth_scene();
  scene.cloths[0].material.porous = false;
  drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.samples.count(), 0);
  EXPECT_TRUE(setup.model.samples.node_capacity.empty());
  EXPECT_EQ(setup.state.sample_count(), 0);
  scene.fluid.present = true;
  setup = build(scene);
  EXPECT_GT(setup.model.samples.count(), 0);
  EXPECT_EQ(sum(setup.model.samples.capacity), 0);
  EXPECT_EQ(setup.state.sample_count(), setup.model.samples.count());
  EXPECT_EQ(setup.state.sample_flow_direction.size(), setup.state.sample_volume.size());
}

TEST(BuildPins, EachKind) {
  Scene scene = cloth_scene({1, 1}, {5, 4});
  const auto pinned = [&](const PinScene& pin) {
    scene.cloths[0].pins.assign(1, pin);
    std::vector<Index> nodes;
    const ClothMesh mesh = build(scene).model.mesh;
    for (Index n = 0; n < mesh.nodes(); ++n) {
      if (mesh.pinned[static_cast<std::size_t>(n)]) nodes.push_back(n);
    }
    return nodes;
  };
  PinScene pin;
  EXPECT_EQ(pinned(pin), (std::vector<Index>{0, 4, 15, 19}));
  pin.kind = PinScene::Kind::edges;
  EXPECT_EQ(pinned(pin), (std::vector<Index>{0, 1, 2, 3, 4, 5, 9, 10, 14, 15, 16, 17, 18, 19}));
  pin.kind = PinScene::Kind::nodes;
  pin.nodes = {3, 7};
  EXPECT_EQ(pinned(pin), (std::vector<Index>{3, 7}));
  pin.nodes = {20};
  scene.cloths[0].pins.assign(1, pin);
  EXPECT_NE(error_of(scene).find("there is no node 20; allowed: 0 to 19"), std::string::npos);
  pin.kind = PinScene::Kind::box;  // after placing: 2 m up
  scene.cloths[0].position = {0, 2, 0};
  pin.box = {{0.4, 1.9, -1}, {0.6, 2.1, 1}};
  EXPECT_EQ(pinned(pin), (std::vector<Index>{4, 9, 14, 19}));
  pin.box = {{0.4, -0.1, -1}, {0.6, 0.1, 1}};
  EXPECT_TRUE(pinned(pin).empty());
  EXPECT_TRUE(any_has(build(scene).warnings, "selects no node"));
  scene.cloths[0].dynamics = false;
  EXPECT_EQ(pinned(pin).size(), 20u);
}

TEST(BuildCloths, ValuesInOtherUnitsAreWarnedOf) {
  Scene scene = cloth_scene();
  EXPECT_FALSE(any_has(build(scene).warnings, "of any fabric"));
  scene.cloths[0].material.thickness = 0.3;
  EXPECT_TRUE(any_has(build(scene).warnings,
                      "its thickness is 0.3 m, more than that of any fabric; the unit is m: 0.3 mm is 0.0003"));
  scene.cloths[0].material.areal_density = 180;
  EXPECT_TRUE(any_has(build(scene).warnings, "the unit is kg/m²: 180 g/m² is 0.18"));
}

TEST(BuildSaturation, FillsAndHoldsNodes) {
  Scene scene = cloth_scene({1, 1}, {5, 5});
  ClothScene& cloth = scene.cloths[0];
  const double inf = 10;
  cloth.initial_saturation = {{{{-inf, -inf, -inf}, {inf, inf, inf}}, 0.5}, {{{0.2, -1, -1}, {1, 1, 1}}, 0.25}};
  cloth.hold_saturation = {{{{-1, -1, -1}, {-0.2, 1, 1}}, 1.0}, {{{-1, -1, 0.4}, {1, 1, 1}}, 1.18}};
  const drench::Setup setup = build(scene);
  const Model& m = setup.model;
  const auto saturation = [&](std::size_t n) {
    return static_cast<double>(setup.state.node_liquid[n]) * m.quantum / m.samples.node_capacity[n];
  };
  // The sheet's samples are coarse, so a quantum is a visible part of a node's capacity.
  const auto quantum_of = [&](std::size_t n) { return m.quantum / m.samples.node_capacity[n]; };
  EXPECT_LT(quantum_of(20), 1e-6);
  EXPECT_NEAR(saturation(12), 0.5, quantum_of(12));
  EXPECT_NEAR(saturation(14), 0.25, quantum_of(14));
  EXPECT_NEAR(saturation(10), 1, quantum_of(10));
  EXPECT_NEAR(saturation(20), 1.18, quantum_of(20));  // in both holding boxes: the later one has it
  EXPECT_LE(static_cast<double>(setup.state.node_liquid[20]), 1.18 * m.samples.node_capacity[20] / m.quantum);
  ASSERT_EQ(m.reservoirs.size(), 2u);
  EXPECT_EQ(m.reservoirs[0].nodes, (std::vector<Index>{0, 1, 5, 6, 10, 11, 15, 16}));
  EXPECT_EQ(m.reservoirs[1].nodes, (std::vector<Index>{20, 21, 22, 23, 24}));
  EXPECT_EQ(m.reservoirs[0].target[0], std::llround(m.samples.node_capacity[0] / m.quantum));
  EXPECT_EQ(setup.state.supplied, 0);
}

TEST(BuildSaturation, RefusesWhatCannotBe) {
  Scene scene = cloth_scene();
  scene.cloths[0].initial_saturation = {{{{-1, -1, -1}, {1, 1, 1}}, 1.2}};
  EXPECT_NE(error_of(scene).find("allowed: 0 to max_saturation = 1.18"), std::string::npos);
  scene.cloths[0].initial_saturation[0].value = 1;
  scene.cloths[0].material.porous = false;
  EXPECT_EQ(error_of(scene), "cloth 'sheet': initial_saturation: the cloth is not porous");
  scene.cloths[0].hold_saturation.swap(scene.cloths[0].initial_saturation);
  EXPECT_EQ(error_of(scene), "cloth 'sheet': hold_saturation: the cloth is not porous");
}

}  // namespace
}  // namespace drench::testing
