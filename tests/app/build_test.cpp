// From a scene to a model: numbers and cloth meshes. Samples and pins of cloth: build_samples_test.cpp; bodies:
// build_geometry_test.cpp; liquid: build_liquid_test.cpp.

#include "setup/build.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "base/eigen_vec.hpp"
#include "build_scenes.hpp"
#include "rolled_sheet.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/surface_mesh.hpp"

namespace drench::testing {
namespace {

TEST(BuildSelfCollision, RefusesThickClothAndIntersections) {
  Scene scene = cloth_scene();
  scene.cloths[0].self_collision = true;
  EXPECT_EQ(error_of(scene), "");
  scene.cloths[0].material.thickness = 0.02;  // triangles 50 mm wide, 35 mm high
  EXPECT_NE(error_of(scene).find("more than half the height of the triangle at ("), std::string::npos);
  EXPECT_NE(error_of(scene).find("which is 0.03536 m high"), std::string::npos) << error_of(scene);
  scene.cloths[0].material.thickness = 0.001;
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
  scene.cloths[0].material.uptake_velocity = 0.3;
  scene.cloths[0].material.emission_angle = 60;
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
  // Cells are 0.05 m squares: an inner axis-aligned edge has A0 + A1 = L², one on the boundary half of that.
  std::size_t inner = 0, boundary = 0, diagonal = 0;
  for (std::size_t e = 0; e < m.mesh.edge.size(); ++e) {
    const double k = m.mesh.edge_stiffness[e] / 500;
    if (std::abs(k - 1) < 1e-12) ++inner;
    if (std::abs(k - 0.5) < 1e-12) (m.mesh.edge_length[e] > 0.06 ? diagonal : boundary) += 1;
  }
  EXPECT_EQ(inner, 10u * 5 + 6 * 9);
  EXPECT_EQ(boundary, 2u * (10 + 6));
  EXPECT_EQ(diagonal, 60u);
  // Differences within the sheet, along its boundary, and twists: bend/L², half and twice that.
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

/// Energy of the rolled 1 m square sheet with n × n nodes over ½ bend κ² A.
double bending_ratio(int n, double curvature, double degrees) {
  const Scene scene = cloth_scene({1, 1}, {n, n});
  const double energy = test::rolled_energy(build(scene).model.mesh, curvature, degrees);
  return energy / (0.5 * scene.cloths[0].material.bend * curvature * curvature);
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
      EXPECT_LT(std::abs(ratio - 1), 0.51 * last + 1e-6) << n;  // first order in a, from the missing boundary
      last = std::abs(ratio - 1);
    }
    RecordProperty("ratio_rolled_along_grid", std::to_string(bending_ratio(81, 0.5, degrees)));
  }
  EXPECT_NEAR(bending_ratio(161, 0.5, 45), 1, 0.01);
}

TEST(BuildLimits, RefusesWhatDoesNotFitBeforeAllocatingIt) {
  Scene scene;
  scene.fluid.present = true;
  scene.fluid.spacing = 1e-4;
  scene.fluid.blocks.push_back({{{-5, -5, -5}, {5, 5, 5}}, {0, 0, 0}});
  EXPECT_NE(error_of(scene).find("the scene is too large: 1000000000000000 fluid particles"), std::string::npos);
  scene = cloth_scene({1, 1}, {2000000000, 2000000000});
  EXPECT_NE(error_of(scene).find("the scene is too large"), std::string::npos);
  const drench::Setup small = build(cloth_scene());
  EXPECT_EQ(size_of(small).nodes, 77);
  EXPECT_EQ(size_of(small).samples, static_cast<double>(small.model.samples.count()));
}

}  // namespace
}  // namespace drench::testing
