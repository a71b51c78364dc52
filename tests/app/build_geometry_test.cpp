// From a scene to a model: bodies and their samples. Liquid: build_liquid_test.cpp; cloth: build_test.cpp; mesh files:
// mesh_files_test.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "base/eigen_vec.hpp"
#include "build_scenes.hpp"
#include "setup/body_geometry.hpp"
#include "setup/build.hpp"
#include "setup/distance_field.hpp"
#include "setup/point_grid.hpp"
#include "setup/smoothing_kernel.hpp"
#include "setup/solid_mesh.hpp"

namespace drench::testing {
namespace {

double cubic(double r, double h) { return kernel_value(KernelKind::cubic, r, h); }

/// Samples lie half a spacing below the surface.
void expect_on_surface(const Setup& setup) {
  for (std::size_t i = 0; i < setup.model.boundary.position.size(); ++i) {
    Vec3 normal;
    const Body& body = setup.model.bodies[static_cast<std::size_t>(setup.model.boundary.body[i])];
    EXPECT_NEAR(signed_distance(body, setup.model.boundary.position[i], normal), -d / 2, 1e-12);
  }
}

TEST(BodyGeometry, DistancesArePositiveOnTheFreeSideAndNormalsAreTheirGradients) {
  BodyScene plane;
  plane.kind = BodyScene::Kind::plane;
  plane.normal = {0, 3, 4};
  plane.point = {0, 0.1, 0};
  const Box box{{-0.3, -0.2, -0.4}, {0.3, 0.5, 0.1}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const BodyScene& scene : {box_body(box), box_body(box, true), sphere_body({0.1, 0.2, 0}, 0.4), plane}) {
    const Body body = make_body(scene, "", "body");
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3 x{uniform(random), uniform(random), uniform(random)};
      Vec3 normal, ignored;
      const double distance = signed_distance(body, x, normal);
      EXPECT_NEAR(to_eigen(normal).norm(), 1, 1e-12);
      constexpr double step = 1e-6;
      const Vec3 ahead = to_vec3(to_eigen(x) + step * to_eigen(normal));
      EXPECT_NEAR((signed_distance(body, ahead, ignored) - distance) / step, 1, 1e-5);
      // The foot of the perpendicular is on the surface.
      const Vec3 foot = to_vec3(to_eigen(x) - distance * to_eigen(normal));
      EXPECT_NEAR(signed_distance(body, foot, ignored), 0, 1e-12);
    }
  }
  Vec3 n;
  EXPECT_DOUBLE_EQ(signed_distance(make_body(box_body(box), "", ""), {0.6, 0.9, 0}, n), 0.5);
  EXPECT_NEAR(signed_distance(make_body(box_body(box, true), "", ""), {0.29, 0, 0}, n), 0.01, 1e-15);
  EXPECT_EQ(n, (Vec3{-1, 0, 0}));
}

/// The surface of a box as twelve triangles, some of them turned inwards.
void make_box_mesh(Body& body, const Box& box) {
  body.kind = BodyScene::Kind::mesh;
  for (int k = 0; k < 8; ++k)
    body.mesh_points.push_back(
        {k & 1 ? box.max[0] : box.min[0], k & 2 ? box.max[1] : box.min[1], k & 4 ? box.max[2] : box.min[2]});
  body.mesh_triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 6, 7}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  body.mesh_triangles = close_mesh({body.mesh_points, body.mesh_triangles}).triangles;
}

TEST(BodyGeometry, TheFieldOfABoxMeshIsTheBoxsDistance) {
  const Box box{{-0.15, -0.1, -0.2}, {0.15, 0.25, 0.05}};
  Body mesh, solid;
  solid.box = box;
  make_box_mesh(mesh, box);
  constexpr double step = 0.02, margin = 0.05;
  mesh.field = lay_field(mesh, step, margin);
  EXPECT_DOUBLE_EQ(mesh.field.spacing, 0.5 * step);
  fill_field(mesh, mesh.field);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  double at_faces = 0, anywhere = 0, deep = 0, slope = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Vec3 x, n, m;
    for (int a = 0; a < 3; ++a) x[a] = box.min[a] - margin + uniform(random) * (box.max[a] - box.min[a] + 2 * margin);
    const double expected = signed_distance(solid, x, n), found = field_distance(mesh.field, x, m);
    const double error = std::abs(found - expected);
    if (expected < -4 * step) {
      deep = std::max(deep, error);
      EXPECT_LT(found, 0);
      continue;
    }
    anywhere = std::max(anywhere, error);
    // Away from edges the distance is linear, and the lattice has it exactly.
    int outside = 0, near = 0;
    for (int a = 0; a < 3; ++a) {
      const double beyond = std::max(box.min[a] - x[a], x[a] - box.max[a]);
      outside += beyond > 0;
      near += beyond > -step - std::abs(expected);
    }
    if (near > 1 || outside > 1) continue;
    at_faces = std::max(at_faces, error);
    slope = std::max(slope, (to_eigen(n) - to_eigen(m)).norm());
  }
  EXPECT_LT(at_faces, 1e-9);
  EXPECT_LT(slope, 1e-6);
  EXPECT_LT(anywhere, 0.25 * step) << "along edges";
  EXPECT_LT(deep, 2.1 * step) << "deep inside, between exact points four lattice steps apart";
  Vec3 n;
  EXPECT_GT(field_distance(mesh.field, {3, 0, 0}, n), 1e29);
}

TEST(BodySamples, BoxHasEdgesAndCornersOnce) {
  Scene scene = wet_scene();
  scene.bodies.push_back(box_body({{0, 0, 0}, {0.2, 0.1, 0.06}}));  // 9 × 4 × 2 steps of d, d/2 inside
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.boundary.count(), 10 * 5 * 3 - 8 * 3 * 1);
  expect_on_surface(setup);
  for (const double r : nearest_distances(setup.model.boundary.position)) EXPECT_NEAR(r, d, 1e-12);
  const auto& x = setup.model.boundary.position;
  const auto corner = [](const Vec3& p) { return std::hypot(p[0] - 0.19, p[1] - 0.09, p[2] - 0.05) < 1e-12; };
  EXPECT_EQ(std::count_if(x.begin(), x.end(), corner), 1);
  EXPECT_EQ(setup.state.boundary_position, x);
  EXPECT_EQ(setup.state.boundary_velocity, std::vector<Vec3>(x.size(), Vec3{0, 0, 0}));
}

TEST(BodySamples, BoxesAreCutAtTheDomainExtendedByTheSupport) {
  Scene scene = wet_scene();
  scene.domain = {{0.03, -1, -1}, {1, 1, 1}};  // − h = −0.01: keeps the face x = 0
  scene.bodies.push_back(box_body({{-0.1, 0, 0}, {0.1, 0.1, 0.1}}));
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.boundary.count(), 6 * 5 * 5 - 5 * 3 * 3);  // six layers from x = -0.01, one of them a face
  for (const Vec3& x : setup.model.boundary.position) EXPECT_GE(x[0], -0.01 - 1e-12);
}

TEST(BodySamples, SphereIsEven) {
  Scene scene = wet_scene();
  scene.bodies.push_back(sphere_body({0.1, 0.2, 0.3}, 0.2));
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.boundary.count(), std::lround(4 * std::numbers::pi * 0.19 * 0.19 / (d * d)));
  expect_on_surface(setup);
  for (const double r : nearest_distances(setup.model.boundary.position)) {
    EXPECT_GT(r, 0.8 * d);
    EXPECT_LT(r, 1.1 * d);
  }
}

TEST(BodySamples, PlaneFillsTheDomain) {
  Scene scene = wet_scene();
  BodyScene plane;
  plane.kind = BodyScene::Kind::plane;
  plane.point = {0, -0.5, 0};
  plane.normal = {0, 2, 0};
  scene.bodies.push_back(plane);
  drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.boundary.count(), 105 * 105);  // −1.04 to 1.04
  expect_on_surface(setup);
  // A flat lattice of spacing d stands for one layer of liquid.
  EXPECT_NEAR(setup.state.boundary_volume[static_cast<std::size_t>(52 * 105 + 52)] / (d * d * d), 1, 1e-9);
  scene.bodies[0].normal = {1, 2, 3};
  setup = build(scene);
  expect_on_surface(setup);
  for (const Vec3& x : setup.model.boundary.position) {
    for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(x[a]), 1.04 + 1e-9);
  }
  scene.fluid.spacing = 2e-4;
  EXPECT_NE(error_of(scene).find("bodies.0: its surface needs more than 20000000 boundary particles"),
            std::string::npos);
}

TEST(BodySamples, VolumesMatchASumOverAllPairs) {
  Scene scene = wet_scene();
  scene.bodies = {sphere_body({0, 0, 0}, 0.1), box_body({{0.1, 0, 0}, {0.2, 0.1, 0.1}})};  // touching: still apart
  const drench::Setup setup = build(scene);
  const auto& x = setup.model.boundary.position;
  const auto& body = setup.model.boundary.body;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (body[i] == body[j]) sum += cubic((to_eigen(x[i]) - to_eigen(x[j])).norm(), 2 * d);
    }
    // by hand: the plane lattice within h = 2 d has 1 point at 0, 4 at d, 4 at √2 d
    const double plane = cubic(0, 2 * d) + 4 * cubic(d, 2 * d) + 4 * cubic(std::numbers::sqrt2 * d, 2 * d);
    EXPECT_NEAR(setup.state.boundary_volume[i] * sum / (d * d * d * plane), 1, 1e-12);
  }
  EXPECT_EQ(setup.model.bodies[1].first_sample, setup.model.bodies[0].sample_count);
}

TEST(BodySamples, KernelsIntegrateToOne) {
  for (const KernelKind kernel : {KernelKind::cubic, KernelKind::wendland, KernelKind::poly6}) {
    double integral = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double r = (i + 0.5) / n;
      integral += 4 * std::numbers::pi * r * r * kernel_value(kernel, r, 1) / n;
    }
    EXPECT_NEAR(integral, 1, 1e-8);
  }
}

TEST(BodySamples, VolumesFollowTheSceneKernel) {
  Scene scene = wet_scene();
  scene.bodies = {sphere_body({0, 0, 0}, 0.1)};
  const auto cubic_volumes = build(scene).state.boundary_volume;
  scene.fluid.kernel = KernelKind::wendland;
  const auto volumes = build(scene).state.boundary_volume;
  ASSERT_EQ(volumes.size(), cubic_volumes.size());
  EXPECT_GT(std::abs(volumes[0] - cubic_volumes[0]), 1e-3 * volumes[0]);
}

TEST(BodySamples, NoneWithoutFluid) {
  Scene scene = wet_scene();
  scene.fluid.present = false;
  scene.bodies.push_back(sphere_body({0, 0, 0}, 0.2));
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.boundary.count(), 0);
  EXPECT_EQ(setup.model.bodies.size(), 1u);
}

}  // namespace
}  // namespace drench::testing
