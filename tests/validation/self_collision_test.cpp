// Cloth that collides with itself: no triangle ever intersects another, and momentum stays.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "paths.hpp"
#include "scene/load.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

using Vector80 = Eigen::Matrix<long double, 3, 1>;

Vector80 vec80(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// Six times the signed volume of a tetrahedron. The nodes' coordinates are floats or doubles, so that in long double
/// its sign is wrong only within some 1e-19 of the size cubed.
long double volume(const Vector80& a, const Vector80& b, const Vector80& c, const Vector80& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Does the segment p q pass through the triangle? It does where p and q lie on different sides and the line has the
/// three edges on one side.
bool passes_through(const Vector80& p, const Vector80& q, const std::array<Vector80, 3>& t) {
  const long double from = volume(t[0], t[1], t[2], p), to = volume(t[0], t[1], t[2], q);
  if ((from > 0) == (to > 0)) return false;
  const bool a = volume(p, q, t[0], t[1]) > 0, b = volume(p, q, t[1], t[2]) > 0, c = volume(p, q, t[2], t[0]) > 0;
  return a == b && b == c;
}

/// Pairs of an edge and a triangle without a common node that intersect: as two triangles meet, an edge of one passes
/// through the other. Exhaustive but for boxes that do not overlap.
int intersections(const Model& m, const HostState& s) {
  struct Item {
    std::array<double, 3> lo, hi;
  };
  const auto box = [&](const auto& nodes) {
    Item item{{1e9, 1e9, 1e9}, {-1e9, -1e9, -1e9}};
    for (const Index n : nodes) {
      for (std::size_t a = 0; a < 3; ++a) {
        const double x = s.node_position[static_cast<std::size_t>(n)][a];
        item.lo[a] = std::min(item.lo[a], x);
        item.hi[a] = std::max(item.hi[a], x);
      }
    }
    return item;
  };
  std::vector<Item> edges;
  for (const auto& e : m.mesh.edge) edges.push_back(box(e));
  const auto at = [&](Index n) { return vec80(s.node_position[static_cast<std::size_t>(n)]); };
  int found = 0;
  for (const auto& t : m.mesh.triangle) {
    const Item own = box(t);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const Item& other = edges[k];
      if (own.lo[0] > other.hi[0] || other.lo[0] > own.hi[0] || own.lo[1] > other.hi[1] || other.lo[1] > own.hi[1] ||
          own.lo[2] > other.hi[2] || other.lo[2] > own.hi[2])
        continue;
      const auto& e = m.mesh.edge[k];
      if (std::count(t.begin(), t.end(), e[0]) + std::count(t.begin(), t.end(), e[1]) > 0) continue;
      found += passes_through(at(e[0]), at(e[1]), {at(t[0]), at(t[1]), at(t[2])});
    }
  }
  return found;
}

/// A zig-zag of `folds` layers, `gap` apart, each `rows` quads deep and `columns` wide, as OBJ. The creases are quads
/// that stand upright.
std::filesystem::path folded_sheet(int folds, int rows, int columns, double cell, double gap) {
  const auto path = own_file("drench_folded_sheet.obj");
  std::ofstream out(path);
  int lines = 0;
  for (int f = 0; f < folds; ++f) {
    for (int r = 0; r <= rows; ++r, ++lines) {
      const double z = cell * (f % 2 == 0 ? r : rows - r);
      for (int c = 0; c <= columns; ++c)
        out << "v " << cell * c << ' ' << f * gap << ' ' << z + 0.03 * cell * std::sin(3.0 * c + 2.0 * f) << '\n';
    }
  }
  for (int r = 0; r + 1 < lines; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int a = r * (columns + 1) + c + 1, b = a + 1, d = a + columns + 1, e = d + 1;
      if ((r + c) % 2 == 0)
        out << "f " << a << ' ' << b << ' ' << e << "\nf " << a << ' ' << e << ' ' << d << '\n';
      else
        out << "f " << a << ' ' << b << ' ' << d << "\nf " << b << ' ' << e << ' ' << d << '\n';
    }
  }
  return path;
}

}  // namespace

TEST(self_collision, a_dropped_folded_sheet_never_intersects_itself) {
  // Four layers of 0.2 m × 0.125 m, 25 mm quads, fall onto a sphere and a floor, unfold, slide and pile up.
  const auto path = folded_sheet(4, 5, 8, 0.025, 0.012);
  const std::string scene = R"(drench: 1
time: {step: 0.005, end: 10}
domain: {min: [-2, -2, -2], max: [2, 2, 2]}
cloth:
  - mesh: {file: )" + path.string() +
                            R"(}
    place: {position: [0, 0.25, 0], rotate: {axis: [1, 0.3, 0.2], degrees: 25}}
    thickness: 0.003
    stretch: 200
    bend: 1.0e-5
    friction: 0.4
    self_collision: )";
  const std::string bodies = R"(
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
  - sphere: {center: [0.1, 0.06, 0.06], radius: 0.05}
)";
  {  // without: the test would see it
    SceneRun through(scene + "false" + bodies);
    ASSERT_EQ(intersections(through.model(), through.initial()), 0);
    while (through.time() < 0.5) through.step();
    EXPECT_GT(intersections(through.model(), through.state()), 20);
  }
  SceneRun run(scene + "true" + bodies);
  int frames = 0, crossed = 0;
  std::int64_t contacts = 0, zones = 0, steps_with_zones = 0;
  double energy = 0;
  for (int step = 1; run.time() < 10 - 1e-9; ++step) {
    const StepReport done = run.step(10 - run.time());
    contacts = std::max(contacts, done.cloth_contacts);
    zones = std::max(zones, done.cloth_zone_nodes);
    steps_with_zones += done.cloth_zone_nodes > 0;
    energy = done.kinetic_energy;
    if (step % 10 != 0) continue;
    ++frames;
    crossed += intersections(run.model(), run.state());
  }
  std::printf(
      "%d nodes, %d triangles, %d frames; most contacts %lld, most nodes in zones %lld, steps with zones %lld, "
      "kinetic energy at the end %.2g J\n",
      run.model().mesh.nodes(), run.model().mesh.triangles(), frames, static_cast<long long>(contacts),
      static_cast<long long>(zones), static_cast<long long>(steps_with_zones), energy);
  EXPECT_GT(contacts, 500);
  EXPECT_GE(frames, 200);
  report({"Folded cloth of four layers dropped, 10 s: edges through triangles at any of 200 frames", "none",
          double(crossed), 0, "pairs"});
  std::filesystem::remove(path);
}

TEST(self_collision, two_sheets_that_collide_keep_their_momentum) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0.013, 0.03, 0.021], rotate: {axis: [0.1, 1, 0.1], degrees: 20}}
    thickness: 0.003
    damping: 0
    self_collision: true
  - name: lower
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    thickness: 0.003
    areal_density: 0.4
    damping: 0
    self_collision: true
)");
  const Model& m = run.model();
  HostState s = run.initial();
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    s.node_velocity[n] = m.mesh.node_cloth[n] == 0 ? Vec3{0.3, -2, 0.1} : Vec3{-0.1, 0.5, 0};
  // The stage alone, 50 times on the way of the sheets: the cloth's own solver conserves what its tolerance lets it.
  const auto backend = make_kokkos_backend(m);
  double drift = 0, size = 0;
  std::int64_t contacts = 0, zones = 0;
  const auto momentum = [&](const HostState& h) {
    Vec3 sum{0, 0, 0};
    size = 0;
    for (std::size_t n = 0; n < h.node_velocity.size(); ++n) {
      for (std::size_t a = 0; a < 3; ++a) sum[a] += m.mesh.solid_mass[n] * h.node_velocity[n][a];
      size += m.mesh.solid_mass[n] * std::hypot(h.node_velocity[n][0], h.node_velocity[n][1], h.node_velocity[n][2]);
    }
    return sum;
  };
  backend->upload(s);
  for (int step = 0; step < 50; ++step) {
    const StepInfo info{step, 0.004 * step, 0.004};
    StepReport done;
    backend->run(Stage::cloth, info, done);
    const Vec3 before = momentum(backend->download());
    backend->run(Stage::self_collision, info, done);
    contacts += done.cloth_contacts;
    zones += done.cloth_zone_nodes;
    const HostState after = backend->download();
    const Vec3 now = momentum(after);
    drift += std::hypot(now[0] - before[0], now[1] - before[1], now[2] - before[2]) / size;
    backend->run(Stage::advection, info, done);
  }
  std::printf("contacts in all %lld, nodes in zones %lld\n", static_cast<long long>(contacts),
              static_cast<long long>(zones));
  EXPECT_GT(contacts, 500);
  report({"Two cloths collide: change of momentum by the stage, sum over 50 steps", "conservation", drift,
          double_precision ? 1e-12 : 1e-6, "of Σ m v"});
  EXPECT_EQ(intersections(m, backend->download()), 0);
}

TEST(self_collision, crumpled_by_kicks_the_sheets_never_intersect) {
  // Every fifth step each node is kicked in its own direction at up to 35 m/s, seven edge lengths a step, within a box
  // that leaves no room: work for the failsafe.
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 1}
domain: {min: [-2, -2, -2], max: [2, 2, 2]}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    place: {position: [0.013, 0.02, 0.021], rotate: {axis: [0.02, 1, 0.03], degrees: 20}}
    thickness: 0.003
    stretch: 20
    self_collision: true
  - name: lower
    mesh: {grid: {size: [0.2, 0.2], nodes: [11, 11]}}
    thickness: 0.002
    stretch: 20
    pin: [{corners: true}]
    self_collision: true
bodies:
  - box: {min: [-0.15, -0.03, -0.15], max: [0.15, 0.05, 0.15], inside: true}
)");
  int crossed = 0, steps_with_zones = 0;
  std::int64_t zones = 0;
  for (int step = 0; step < 60; ++step) {
    if (step % 5 == 0) {
      HostState s = run.state();
      for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
        for (std::size_t a = 0; a < 3; ++a)
          s.node_velocity[n][a] += 20 * std::sin(12.9898 * double(n) + 78.233 * double(a) + 3.7 * step);
      run.restart(s);
    }
    const StepReport done = run.step();
    zones = std::max(zones, done.cloth_zone_nodes);
    steps_with_zones += done.cloth_zone_nodes > 0;
    crossed += intersections(run.model(), run.state());
  }
  std::printf("steps with zones %d, most nodes in them %lld\n", steps_with_zones, static_cast<long long>(zones));
  EXPECT_GT(steps_with_zones, 5);
  report({"Two cloths in a flat box, nodes kicked at up to 35 m/s, 60 steps: edges through triangles at any step",
          "none", double(crossed), 0, "pairs"});
}

}  // namespace drench::test
