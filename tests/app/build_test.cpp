// From a scene to a model: numbers, cloth meshes, samples, pins, saturation. Bodies and liquid:
// build_geometry_test.cpp.

#include "scene/build.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "scene/cloth_mesh.hpp"
#include "scene/eigen_vec.hpp"
#include "scene/surface_mesh.hpp"

namespace drench {
namespace {

Scene cloth_scene(std::array<double, 2> size = {0.5, 0.3}, std::array<int, 2> nodes = {11, 7}) {
  Scene scene;
  ClothScene cloth;
  cloth.name = "sheet";
  cloth.grid = GridScene{size, nodes};
  cloth.porous.present = true;
  scene.cloths.push_back(cloth);
  return scene;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

std::string error_of(const Scene& scene) {
  try {
    build(scene);
  } catch (const SetupError& e) {
    return e.what();
  }
  return "";
}

bool any_has(const std::vector<std::string>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& l) { return l.find(text) != std::string::npos; });
}

TEST(BuildSelfCollision, RefusesThickClothAndIntersections) {
  Scene scene = cloth_scene();
  scene.cloths[0].self_collision = true;
  EXPECT_EQ(error_of(scene), "");
  scene.cloths[0].thickness = 0.02;  // triangles 50 mm wide, 35 mm high
  EXPECT_NE(error_of(scene).find("too thick for a triangle of height 0.03536 m"), std::string::npos) << error_of(scene);
  scene.cloths[0].thickness = 0.001;
  scene.cloths.push_back(scene.cloths[0]);
  scene.cloths[1].name = "upright";
  scene.cloths[1].rotate_degrees = 80;
  scene.cloths[1].position = {0.013, 0.007, 0.011};
  EXPECT_NE(error_of(scene).find("intersects cloth"), std::string::npos) << error_of(scene);
  scene.cloths[1].position = {0, 0.4, 0};
  EXPECT_EQ(error_of(scene), "");
  scene.cloths[1].position = {0, 0, 0};
  scene.cloths[1].self_collision = false;
  EXPECT_EQ(error_of(scene), "");
}

TEST(BuildNumbers, FollowTheFluidSection) {
  Scene scene = cloth_scene();
  scene.fluid.present = true;
  scene.fluid.spacing = 0.02;
  scene.fluid.support = 2.5;
  scene.fluid.density = 998;
  scene.cloths[0].porous.uptake_velocity = 0.3;
  scene.cloths[0].porous.emission_angle = 60;
  const Model m = build(scene).model;
  EXPECT_DOUBLE_EQ(m.spacing, 0.02);
  EXPECT_DOUBLE_EQ(m.support, 0.05);
  EXPECT_DOUBLE_EQ(m.particle_mass, 998 * 8e-6);
  EXPECT_DOUBLE_EQ(m.quantum * 4294967296.0, m.particle_mass);
  EXPECT_EQ(m.min_quanta, 214748365);  // 0.05 · 2^32 = 214748364.8
  EXPECT_NEAR(m.cloths[0].absorption, 0.3 * 0.05 * 0.05 / (7.5 * 0.6 * 0.001), 1e-15);
  EXPECT_NEAR(m.cloths[0].emission_cosine, 0.5, 1e-15);
}

TEST(BuildNumbers, WithoutFluidTheClothsEdgesSetTheSpacing) {
  const Model m = build(cloth_scene()).model;
  EXPECT_NEAR(m.spacing, sum(m.mesh.edge_length) / static_cast<double>(m.mesh.edge.size()), 1e-15);
  EXPECT_EQ(m.samples.count(), m.mesh.triangles());  // one sample a triangle
}

TEST(BuildCloth, GridSpansXAndZWithAlternatingDiagonals) {
  const drench::Setup setup = build(cloth_scene({0.5, 0.3}, {3, 4}));
  const ClothMesh& mesh = setup.model.mesh;
  ASSERT_EQ(mesh.nodes(), 12);
  ASSERT_EQ(mesh.triangles(), 12);
  EXPECT_EQ(mesh.edge.size(), 2u * 4 + 3 * 3 + 6);   // along x, along z, diagonals: V − E + F = 1
  EXPECT_EQ(mesh.hinge.size(), 1u * 4 + 3 * 2 + 6);  // differences along x, along z, twists of cells
  EXPECT_EQ(mesh.rest_position[0], (Vec3{-0.25, 0, -0.15}));
  EXPECT_EQ(mesh.rest_position[11], (Vec3{0.25, 0, 0.15}));
  EXPECT_EQ(setup.state.node_position, mesh.rest_position);
  // Union jack: the middle node of 3 × 3 takes part in all diagonals or in none, so it has 8 edges or 4.
  EXPECT_EQ(mesh.node_edges.start[5] - mesh.node_edges.start[4], 8);
  EXPECT_EQ(mesh.node_edges.start[8] - mesh.node_edges.start[7], 4);
  for (const auto& t : mesh.triangle) {
    const auto x = [&](int c) { return to_eigen(mesh.rest_position[static_cast<std::size_t>(t[c])]); };
    EXPECT_GT((x(1) - x(0)).cross(x(2) - x(0)).y(), 0);
  }
}

TEST(BuildCloth, IsRotatedThenMoved) {
  Scene scene = cloth_scene({2, 1}, {2, 2});
  scene.cloths[0].rotate_axis = {0, 0, 2};
  scene.cloths[0].rotate_degrees = 90;
  scene.cloths[0].position = {5, 6, 7};
  const Vec3 x = build(scene).model.mesh.rest_position[1];  // was (1, 0, −0.5)
  EXPECT_NEAR(x[0], 5, 1e-14);
  EXPECT_NEAR(x[1], 7, 1e-14);
  EXPECT_NEAR(x[2], 6.5, 1e-14);
}

TEST(BuildCloth, MassesAndStiffnesses) {
  const Model m = build(cloth_scene()).model;
  EXPECT_NEAR(sum(m.mesh.solid_mass), 0.2 * 0.15, 1e-15);
  for (std::size_t e = 0; e < m.mesh.edge.size(); ++e) {
    EXPECT_LT(m.mesh.edge[e][0], m.mesh.edge[e][1]);
  }
  // Cells are 0.05 m squares: an inner axis-aligned edge has A0 + A1 = L², one on the rim half of that.
  std::size_t inner = 0, rim = 0, diagonal = 0;
  for (std::size_t e = 0; e < m.mesh.edge.size(); ++e) {
    const double k = m.mesh.edge_stiffness[e] / 500;
    if (std::abs(k - 1) < 1e-12) ++inner;
    if (std::abs(k - 0.5) < 1e-12) (m.mesh.edge_length[e] > 0.06 ? diagonal : rim) += 1;
  }
  EXPECT_EQ(inner, 10u * 5 + 6 * 9);
  EXPECT_EQ(rim, 2u * (10 + 6));
  EXPECT_EQ(diagonal, 60u);
  // Differences within the sheet, along its rim, and twists: bend/L², half and twice that.
  std::array<std::size_t, 3> bends{};
  for (const double k : m.mesh.hinge_stiffness) {
    const double share = k * 0.0025 / 1e-4;
    for (const auto& [value, count] : {std::pair(1.0, &bends[0]), std::pair(0.5, &bends[1]), std::pair(2.0, &bends[2])})
      if (std::abs(share - value) < 1e-12) ++*count;
  }
  EXPECT_EQ(bends, (std::array<std::size_t, 3>{9u * 5 + 9 * 5, 2u * (9 + 5), 60u}));
}

TEST(BuildCloth, RowsAreTheInverseOfTheLists) {
  Scene scene = cloth_scene();
  scene.cloths.push_back(scene.cloths[0]);
  scene.cloths[1].name = "other";
  scene.cloths[1].grid->nodes = {4, 5};
  const Model m = build(scene).model;
  ASSERT_EQ(m.mesh.node_edges.rows(), m.mesh.nodes());
  ASSERT_EQ(m.mesh.node_hinges.rows(), m.mesh.nodes());
  ASSERT_EQ(m.samples.node_samples.rows(), m.mesh.nodes());
  EXPECT_EQ(m.mesh.node_edges.item.size(), 2 * m.mesh.edge.size());
  EXPECT_EQ(m.mesh.node_hinges.item.size(), 4 * m.mesh.hinge.size());
  EXPECT_EQ(m.samples.node_samples.item.size(), 3 * static_cast<std::size_t>(m.samples.count()));
  const auto each = [](const Rows& rows, auto&& f) {
    for (Index n = 0; n < rows.rows(); ++n) {
      for (Index i = rows.start[static_cast<std::size_t>(n)]; i < rows.start[static_cast<std::size_t>(n) + 1]; ++i) {
        if (i > rows.start[static_cast<std::size_t>(n)]) {
          EXPECT_LT(rows.item[static_cast<std::size_t>(i) - 1], rows.item[static_cast<std::size_t>(i)]);
        }
        f(n, static_cast<std::size_t>(rows.item[static_cast<std::size_t>(i)]));
      }
    }
  };
  each(m.mesh.node_edges,
       [&](Index n, std::size_t e) { EXPECT_TRUE(m.mesh.edge[e][0] == n || m.mesh.edge[e][1] == n); });
  each(m.mesh.node_hinges, [&](Index n, std::size_t i) { EXPECT_EQ(m.mesh.hinge[i / 4][i % 4], n); });
  each(m.samples.node_samples, [&](Index n, std::size_t i) {
    EXPECT_EQ(m.mesh.triangle[static_cast<std::size_t>(m.samples.triangle[i / 4])][i % 4], n);
  });
  EXPECT_EQ(m.cloths[1].first_node, m.cloths[0].node_count);
  EXPECT_EQ(m.cloths[1].first_sample, m.cloths[0].sample_count);
  EXPECT_EQ(m.cloths[1].first_sample + m.cloths[1].sample_count, m.samples.count());
}

TEST(BuildCloth, HingesAnnihilateAffineMapsOfTheFlatRestShape) {
  Scene scene = cloth_scene();
  scene.cloths[0].rotate_degrees = 33;
  scene.cloths[0].rotate_axis = {1, 2, 3};
  const ClothMesh mesh = build(scene).model.mesh;
  Eigen::Matrix3d map;
  map << 1.3, 0.2, -0.4, 0.1, 0.7, 0.9, -0.6, 0.3, 1.1;
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    double weights = 0;
    Eigen::Vector3d bend = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) {
      weights += mesh.hinge_weight[h][c];
      const auto x = to_eigen(mesh.rest_position[static_cast<std::size_t>(mesh.hinge[h][c])]);
      bend += mesh.hinge_weight[h][c] * (map * x + Eigen::Vector3d(1, -2, 3));
    }
    EXPECT_NEAR(weights, 0, 1e-12);
    EXPECT_LT(bend.norm(), 1e-12);
  }
}

TEST(BuildCloth, HingeOfAnIrregularFlatQuadAnnihilatesAffineMapsToo) {
  const Vec3 x0{0.1, 0, 0.2}, x1{1.3, 0, -0.1}, x2{0.9, 0, 1.7}, x3{0.2, 0, -0.8};
  const auto k = hinge_cotangents(x0, x1, x2, x3);
  EXPECT_NEAR(k[0] + k[1] + k[2] + k[3], 0, 1e-14);
  EXPECT_LT((k[0] * to_eigen(x0) + k[1] * to_eigen(x1) + k[2] * to_eigen(x2) + k[3] * to_eigen(x3)).norm(), 1e-14);
  // Folded by θ about the shared edge, |Σ K x| is 2 L sin(θ/2).
  const Eigen::Vector3d axis = (to_eigen(x1) - to_eigen(x0)).normalized();
  const double theta = 0.7, length = (to_eigen(x1) - to_eigen(x0)).norm();
  const Eigen::Vector3d folded = to_eigen(x0) + Eigen::AngleAxisd(theta, axis) * (to_eigen(x3) - to_eigen(x0));
  const Eigen::Vector3d sum = k[0] * to_eigen(x0) + k[1] * to_eigen(x1) + k[2] * to_eigen(x2) + k[3] * folded;
  EXPECT_NEAR(sum.norm(), 2 * length * std::sin(theta / 2), 1e-13);
}

/// Energy Σ ½ c |Kᵀx|² of the 1 m square sheet with n × n nodes, rolled on a cylinder of curvature κ whose axis is
/// turned by `degrees` in the sheet's plane, over ½ bend κ² A.
double bending_ratio(int n, double curvature, double degrees) {
  const Scene scene = cloth_scene({1, 1}, {n, n});
  const ClothMesh mesh = build(scene).model.mesh;
  const double turn = degrees * std::numbers::pi / 180;
  double energy = 0;
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    Eigen::Vector3d bend = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) {
      const Vec3& x = mesh.rest_position[static_cast<std::size_t>(mesh.hinge[h][c])];
      const double across = x[0] * std::cos(turn) + x[2] * std::sin(turn);
      const double along = -x[0] * std::sin(turn) + x[2] * std::cos(turn);
      const double phi = across * curvature;
      bend += mesh.hinge_weight[h][c] * Eigen::Vector3d(std::sin(phi) / curvature, std::cos(phi) / curvature, along);
    }
    energy += 0.5 * mesh.hinge_stiffness[h] * bend.squaredNorm();
  }
  return energy / (0.5 * scene.cloths[0].bend * curvature * curvature);
}

TEST(BuildCloth, BendingEnergyOfARolledSheetConverges) {
  // `bend` is the flexural rigidity along the grid's lines and along its diagonals.
  // tests/validation/bending_test.cpp has other meshes and directions.
  for (const double degrees : {0.0, 90.0}) {
    double last = 1;
    for (const int n : {11, 21, 41, 81}) {
      const double ratio = bending_ratio(n, 0.5, degrees), a = 1.0 / (n - 1);
      // n − 2 nodes of n − 1 cells in a line have a difference; each |Kᵀx| is (4/κ) sin²(κ a / 2).
      const double exact = (n - 2.0) / (n - 1.0) * std::pow(std::sin(0.25 * a) / (0.25 * a), 4);
      EXPECT_NEAR(ratio, exact, 1e-8) << n;
      EXPECT_LT(std::abs(ratio - 1), 0.51 * last + 1e-6) << n;  // first order in a, from the missing rim
      last = std::abs(ratio - 1);
    }
    RecordProperty("ratio_rolled_along_grid", std::to_string(bending_ratio(81, 0.5, degrees)));
  }
  EXPECT_NEAR(bending_ratio(161, 0.5, 45), 1, 0.01);
}

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
  scene.cloths[0].porous.present = false;
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
    scene.cloths[0].pins = {pin};
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
  scene.cloths[0].pins = {pin};
  EXPECT_NE(error_of(scene).find("there is no node 20; allowed: 0 to 19"), std::string::npos);
  pin.kind = PinScene::Kind::box;  // after placing: 2 m up
  scene.cloths[0].position = {0, 2, 0};
  pin.box = {{0.4, 1.9, -1}, {0.6, 2.1, 1}};
  EXPECT_EQ(pinned(pin), (std::vector<Index>{4, 9, 14, 19}));
  pin.box = {{0.4, -0.1, -1}, {0.6, 0.1, 1}};
  EXPECT_TRUE(pinned(pin).empty());
  EXPECT_TRUE(any_has(build(scene).warnings, "catches no node"));
  scene.cloths[0].dynamics = false;
  EXPECT_EQ(pinned(pin).size(), 20u);
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
  scene.cloths[0].porous.present = false;
  EXPECT_EQ(error_of(scene), "cloth 'sheet': initial_saturation: the cloth is not porous");
  scene.cloths[0].hold_saturation.swap(scene.cloths[0].initial_saturation);
  EXPECT_EQ(error_of(scene), "cloth 'sheet': hold_saturation: the cloth is not porous");
}

TEST(BuildLimits, RefusesWhatDoesNotFitBeforeAllocatingIt) {
  Scene scene;
  scene.fluid.present = true;
  scene.fluid.spacing = 1e-4;
  scene.fluid.blocks.push_back({{{-5, -5, -5}, {5, 5, 5}}, {0, 0, 0}});
  EXPECT_NE(error_of(scene).find("the scene is too large: 1000000000000000 liquid particles"), std::string::npos);
  scene = cloth_scene({1, 1}, {2000000000, 2000000000});
  EXPECT_NE(error_of(scene).find("the scene is too large"), std::string::npos);
  const drench::Setup small = build(cloth_scene());
  EXPECT_EQ(size_of(small).nodes, 77);
  EXPECT_EQ(size_of(small).samples, static_cast<double>(small.model.samples.count()));
}

}  // namespace
}  // namespace drench
