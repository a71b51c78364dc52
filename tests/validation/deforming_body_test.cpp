// Bodies that change their shape, from mesh files: a piston whose face bulges displaces the water that it sweeps, none
// is in it, a ball that swells in a pool lifts the pool, and a sheet rests on a body that has bulged.

#include "setup/deforming_body.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "piston_pool.hpp"
#include "setup/distance_field.hpp"
#include "state/deforming_body.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double fps = 20;

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// How deep the deepest particle is in the mesh, m; exact to its triangles.
double deepest(const Body& body, const HostState& s, double time) {
  const Body now = shape_at(body, time);
  const auto distance = exact_distance(now);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : now.mesh_points) bounds.extend(to_eigen(x));
  double inside = 0;
  for (const Vec3& x : s.fluid_position)
    if (bounds.contains(to_eigen(x))) inside = std::max(inside, -distance(x));
  return inside;
}

/// A box [−1, 1]³ whose face at x = 1 has n × n squares; its points have y and z there, and x = ±1.
TestMesh piston_mesh(int n) {
  TestMesh mesh;
  const auto add = [&](double x, double y, double z) {
    mesh.points.emplace_back(x, y, z);
    return static_cast<int>(mesh.points.size()) - 1;
  };
  std::vector<std::vector<int>> front(static_cast<std::size_t>(n) + 1), back(front);
  for (std::size_t i = 0; i < front.size(); ++i)
    for (std::size_t j = 0; j < front.size(); ++j)
      for (auto* face : {&front, &back})
        (*face)[i].push_back(
            add(face == &front ? 1 : -1, 2.0 * static_cast<double>(i) / n - 1, 2.0 * static_cast<double>(j) / n - 1));
  const auto square = [&](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  const auto last = front.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    for (std::size_t j = 0; j < last; ++j) {
      square(front[i][j], front[i + 1][j], front[i + 1][j + 1], front[i][j + 1]);
      square(back[i][j], back[i][j + 1], back[i + 1][j + 1], back[i + 1][j]);
    }
    square(front[i][0], back[i][0], back[i + 1][0], front[i + 1][0]);
    square(front[i + 1][last], back[i + 1][last], back[i][last], front[i][last]);
    square(front[0][i + 1], back[0][i + 1], back[0][i], front[0][i]);
    square(front[last][i], back[last][i], back[last][i + 1], front[last][i + 1]);
  }
  return mesh;
}

}  // namespace

/// The piston's back stays, its sides become longer, and its face bulges by 3 cm between the side walls.
TEST(deforming_body, a_piston_that_bulges_displaces_the_water_that_it_sweeps) {
  constexpr PistonPool pool;
  constexpr double width = pool.width, way = 0.08, bulge = 0.03;  // m
  const auto bulging = [](double z) { return 0.5 * (1 + std::cos(2 * std::numbers::pi * z / width)); };
  const std::string files = write_shapes("bulging_piston", 50, piston_mesh(12), [&](int k, const Vector3d& x) {
    const double s = smooth(k / fps - 1), z = 0.6 * width * x[2];  // 8 mm beyond the walls on both sides
    const double face = s * (way + bulge * (std::abs(z) < width / 2 ? bulging(z) : 0));
    return Vector3d(x[0] > 0 ? face : -0.1, 0.15 + 0.2 * x[1], z);
  });
  double inside = 0;
  int steps = 0;
  Index samples = 0;
  const double swept = pool.floor_taken(files, fps, [&](const SceneRun& run, const HostState& s) {
    const Body& piston = run.model().bodies[1];
    EXPECT_TRUE(piston.deforms());
    samples = piston.sample_count;
    if (++steps % 3 == 0) inside = std::max(inside, deepest(piston, s, run.time()));
  });
  double expected = 0;  // m²: of the floor, from the triangles' straight sides
  for (int j = 0; j < 1200; ++j) {
    const double z = width * ((j + 0.5) / 1200 - 0.5), column = (z / (0.6 * width) + 1) * 6, low = std::floor(column);
    const auto at = [&](double k) {
      const double there = 0.6 * width * (k / 6 - 1);
      return way + bulge * (std::abs(there) < width / 2 ? bulging(there) : 0);
    };
    expected += width / 1200 * std::lerp(at(low), at(low + 1), column - low);
  }
  std::printf("floor covered: %.6f m², expected %.6f; deepest %.2e m; %d samples\n", swept, expected, inside, samples);
  report({"a piston of mesh files whose face bulges: displaced volume, from the centre of mass", "swept volume",
          std::abs(swept / expected - 1), 0.02});
  report({"a piston of mesh files whose face bulges: deepest penetration of a particle over d", "none inside",
          inside / pool.spacing, 0.02});
}

/// The ball becomes a larger ellipsoid. Its distances are off by some 0.02 d at a radius of 5 d, because they are
/// interpolated.
TEST(deforming_body, a_ball_that_swells_in_a_pool_has_no_particle_in_it) {
  constexpr double d = 0.01, side = 0.12, depth = 0.2, small = 0.055;  // m
  const auto radii = [](double t) {
    const double s = smooth(t - 0.5);
    return Vector3d(small * (1 + 0.7 * s), small * (1 + 0.3 * s), small * (1 + 0.5 * s));
  };
  const std::string files = write_shapes("swelling_ball", 32, ball_mesh(4), [&](int k, const Vector3d& x) {
    return Vector3d(radii(k / fps).cwiseProduct(x) + Vector3d(0, 0.1, 0));
  });
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10, mode: cfl}}
domain: {{min: [-0.3, -0.1, -0.3], max: [0.3, 1, 0.3]}}
output: {{every: 0}}
fluid:
  spacing: {0}
  viscosity: 2.0e-3
  sources: [{{block: {{min: [-{1}, 0, -{1}], max: [{1}, {2}, {1}]}}}}]
bodies:
  - box: {{min: [-{1}, 0, -{1}], max: [{1}, 0.6, {1}], inside: true}}
  - mesh: {{sequence: "{3}", fps: {4}}}
)",
                           d, side, depth, files, fps));
  const Body& ball = run.model().bodies[1];
  ASSERT_TRUE(ball.deforms());
  double inside = 0, lifted = -mean_height(run.initial());
  while (run.time() < 1.8) {
    run.step();
    inside = std::max(inside, deepest(ball, run.state(), run.time()));
  }
  lifted += mean_height(run.state());
  std::printf("lifted by %.4f m; deepest %.2e m\n", lifted, inside);
  EXPECT_GT(lifted, 0.01) << "it displaces a litre in 12";
  report({"a sphere of mesh files that swells: deepest penetration of a particle over d", "none inside", inside / d,
          0.02});
}

/// A flat body under a sheet bulges up in the middle. Then the sheet lies on it.
TEST(deforming_body, a_sheet_rests_on_a_body_that_has_bulged) {
  constexpr double thickness = 0.004;  // m
  const std::string files = write_shapes("bulging_cushion", 21, ball_mesh(5), [](int k, const Vector3d& x) {
    const double s = smooth(k / fps), radius = std::hypot(x[0], x[2]);
    return Vector3d(0.25 * x[0], 0.05 * x[1] + (x[1] > 0 ? 0.08 * s * std::exp(-3 * radius * radius) * x[1] : 0),
                    0.25 * x[2]);
  });
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10}}
output: {{every: 0}}
cloth:
  - mesh: {{grid: {{size: [0.3, 0.3], nodes: [25, 25]}}}}
    place: {{position: [0, 0.06, 0]}}
    thickness: {}
    damping: 4
    friction: 0.5
bodies: [{{mesh: {{sequence: "{}", fps: {}}}}}]
)",
                           thickness, files, fps));
  const Body& cushion = run.model().bodies[0];
  ASSERT_TRUE(cushion.deforms());
  double deepest_node = 0;
  while (run.time() < 3) {
    run.step();
    if (std::fmod(run.time(), 0.1) > 0.005) continue;
    const auto distance = exact_distance(shape_at(cushion, run.time()));
    for (const Vec3& x : run.state().node_position) deepest_node = std::max(deepest_node, thickness - distance(x));
  }
  const HostState end = run.state();
  const auto distance = exact_distance(shape_at(cushion, run.time()));
  const Vec3& middle = end.node_position[12 * 25 + 12];
  double fastest = 0, load = 0;
  for (const Vec3& v : end.node_velocity) fastest = std::max(fastest, to_eigen(v).norm());
  for (const Vec3& f : end.node_contact_force) load += f[1];
  double weight = 0;
  for (const double mass : run.model().mesh.solid_mass) weight += 9.81 * mass;
  double friction = 0;
  for (const Vec3& f : end.node_friction_force) friction += f[1];
  std::printf("middle at %.5f m, distance %.6f m; fastest %.2e m/s; load %.4f + %.4f N of %.4f N; deepest %.2e m\n",
              middle[1], distance(middle), fastest, load, friction, weight, deepest_node);
  report({"a cloth on a body that has bulged: distance of its centre from the body over its thickness", "the thickness",
          std::abs(distance(middle) / thickness - 1), 0.02});
  report({"a cloth on a body that bulges: deepest penetration of a node over the thickness", "0",
          deepest_node / thickness, 0.1});
  report({"a cloth on a body that has bulged: the body's force over the cloth's weight", "the weight",
          std::abs((load + friction) / weight - 1), 0.02});
}

}  // namespace drench::test
