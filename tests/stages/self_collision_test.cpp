// Stage self_collision: backend against reference from identical input, and its momentum.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

/// Two sheets, one above the other, above a floor; meshes and places such that no edges are parallel.
const char* const two_sheets = R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, 0]
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
cloth:
  - name: upper
    mesh: {grid: {size: [0.2, 0.2], nodes: [8, 7]}}
    place: {position: [0.003, 0.006, 0.001], rotate: {axis: [0.02, 1, 0.04], degrees: 17}}
    thickness: 0.004
    friction: 0.4
    self_collision: true
  - name: lower
    mesh: {grid: {size: [0.22, 0.18], nodes: [7, 8]}}
    thickness: 0.002
    friction: 0.2
    self_collision: true
bodies:
  - plane: {point: [0, -0.03, 0], normal: [0, 1, 0]}
)";

/// Waves in both sheets, so that nearest points are isolated; the upper falls on the lower at `speed`; above 20 m/s the
/// sheets crumple, too. Coordinates are floats, so that both precisions start from the same.
void throw_sheets(const Model& m, HostState& s, double speed) {
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    const bool upper = m.mesh.node_cloth[n] == 0;
    for (int a = 0; a < 3; ++a) {
      s.node_position[n][a] = float(s.node_position[n][a] + (a == 1 ? 3e-4 : 4e-4) * noise(n, a));
      s.node_velocity[n][a] = float((speed > 20 ? 15 : 0.05) * noise(n, a + 3));
    }
    if (upper) {
      s.node_velocity[n][0] = float(s.node_velocity[n][0] + 0.3);
      s.node_velocity[n][1] = float(s.node_velocity[n][1] - speed);
    }
  }
}

Comparison thrown(double speed, const std::string& scene = two_sheets) {
  return {.stage = Stage::self_collision,
          .scene = scene,
          .steps_before = 0,
          .prepare = [speed](const Model& m, HostState& s) { throw_sheets(m, s, speed); },
          .changes = "node_velocity"};
}

}  // namespace

TEST(self_collision, agrees_with_the_reference) { compare_stage(thrown(1.2)); }

TEST(self_collision, sheets_thrown_through_each_other_and_a_floor_agree_with_the_reference) {
  compare_stage(thrown(30));
}

TEST(self_collision, with_a_pinned_sheet_agrees_with_the_reference) {
  compare_stage(thrown(2, with(two_sheets, "    thickness: 0.002\n", "    thickness: 0.002\n    dynamics: false\n")));
}

TEST(self_collision, with_moving_pins_agrees_with_the_reference) {
  // The upper sheet's corners are driven through the lower one, whose corners turn.
  const std::string upper = with(two_sheets, "    thickness: 0.004\n",
                                 "    thickness: 0.004\n    pin: [{corners: true, velocity: [0, -2, 0.3]}]\n");
  const std::string both = with(upper, "    thickness: 0.002\n",
                                "    thickness: 0.002\n    pin: [{corners: true, velocity: [0.2, 0, 0], "
                                "spin: {axis: [0, 1, 0], degrees_per_second: 300}}]\n");
  for (const double speed : {2.0, 30.0}) compare_stage(thrown(speed, both));
}

TEST(self_collision, pins_throw_no_node_by_a_lever) {
  // A fixed node 0.3 mm above a triangle that is held at two corners, near one of them: to open the gap by 0.2 mm the
  // third corner would have to go twenty times as far, at 1 m/s.
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.004, end: 1}
gravity: [0, 0, 0]
cloth:
  - name: lower
    mesh: {grid: {size: [0.2, 0.2], nodes: [2, 2]}}
    thickness: 0.002
    self_collision: true
    pin: [{nodes: [0, 1, 2]}]
  - name: upper
    mesh: {grid: {size: [0.1, 0.1], nodes: [2, 2]}}
    place: {position: [0.143, 0.016, -0.041], rotate: {axis: [0, 0, 1], degrees: 12}}
    thickness: 0.002
    self_collision: true
    dynamics: false
)");
  HostState s = setup.state;
  // The upper sheet's first corner is the lowest.
  s.node_position[4] = {0.0853, 0.0003, -0.0871};
  run_on_both(setup.model, s, {Stage::self_collision}, {0, 0, 0.004}, [&](const Backend& backend, const StepReport&) {
    double fastest = 0;
    for (const Vec3& v : backend.download().node_velocity) fastest = std::max(fastest, std::hypot(v[0], v[1], v[2]));
    EXPECT_LE(fastest, 2 * 0.1 * 0.002 / 0.004) << "m/s, of twice the gap in a step";
  });
}

/// Both sheets in the plane y = 0: all of their pairs there coincide, and their sides are told by normals and motion.
void lay_into_one_plane(HostState& s, const Model& m, double speed) {
  throw_sheets(m, s, 0);
  for (std::size_t n = 0; n < s.node_position.size(); ++n) {
    s.node_position[n][1] = 0;
    s.node_velocity[n][1] = float(0.01 * noise(n, 7) + (m.mesh.node_cloth[n] == 0 ? speed : 0));
  }
}

TEST(self_collision, coincident_sheets_agree_with_the_reference) {
  const std::string turned = with(two_sheets, "axis: [0.02, 1, 0.04], degrees: 17", "axis: [1, 0, 0.1], degrees: 180");
  for (const std::string& scene : {std::string(two_sheets), turned})
    for (const double speed : {0.0, 0.3, -0.3}) {
      SCOPED_TRACE(speed);
      compare_stage({.stage = Stage::self_collision,
                     .scene = scene,
                     .steps_before = 0,
                     .prepare = [speed](const Model& m, HostState& s) { lay_into_one_plane(s, m, speed); },
                     .changes = "node_velocity"});
    }
}

/// Whichever way the upper sheet leaves, nothing holds it. There is no friction, which edges beside each other in the
/// plane have.
TEST(self_collision, coincident_sheets_part_to_either_side) {
  const auto setup = setup_from(with(with(two_sheets, "friction: 0.4", "friction: 0"), "friction: 0.2", "friction: 0"));
  for (const double speed : {0.5, -0.5}) {
    SCOPED_TRACE(speed);
    HostState s = setup.state;
    lay_into_one_plane(s, setup.model, speed);
    for (Vec3& v : s.node_velocity) v[0] = v[2] = 0;
    run_on_both(setup.model, s, {Stage::self_collision}, {0, 0, 0.004},
                [&](const Backend& backend, const StepReport& r) {
                  EXPECT_GT(r.cloth_contacts, 10) << backend.name();
                  EXPECT_EQ(r.cloth_zone_nodes, 0) << backend.name();
                  const HostState after = backend.download();
                  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
                    EXPECT_NEAR(after.node_velocity[n][1], s.node_velocity[n][1], 0.03) << backend.name() << " " << n;
                });
  }
}

TEST(self_collision, impact_zones_are_needed_and_agree_with_the_reference) {
  const auto setup = setup_from(two_sheets);
  HostState s = setup.state;
  throw_sheets(setup.model, s, 30);
  run_on_both(setup.model, s, {Stage::self_collision}, {0, 0, 0.004}, [](const Backend&, const StepReport& report) {
    EXPECT_GT(report.cloth_contacts, 100);
    EXPECT_GT(report.cloth_zone_nodes, 4);
  });
}

// Zones of many nodes that several pairs join at once: each must end up whole.
TEST(self_collision, zones_that_grow_into_each_other_agree_with_the_reference) {
  const std::string fine =
      with(with(two_sheets, "size: [0.2, 0.2], nodes: [8, 7]", "size: [0.6, 0.6], nodes: [24, 21]"),
           "size: [0.22, 0.18], nodes: [7, 8]", "size: [0.66, 0.54], nodes: [21, 24]");
  compare_stage(thrown(30, fine));
}

// The nodes weigh more than 10⁵ particles each, and what they carry away at 30 m/s is more than 2^63 quanta · 2^-12
// m/s.
TEST(self_collision, zones_of_heavy_and_fast_sheets_agree_with_the_reference) {
  std::string heavy = with(two_sheets, "thickness: 0.004", "thickness: 0.004\n    areal_density: 900");
  heavy = with(heavy, "thickness: 0.002", "thickness: 0.002\n    areal_density: 700");
  heavy = with(heavy, "domain: {min: [-1, -1, -1], max: [1, 1, 1]}",
               R"(domain: {min: [-0.2, -0.2, -0.2], max: [0.2, 0.2, 0.2]}
fluid: {spacing: 0.001, sources: [{block: {min: [0, 0.1, 0], max: [0.002, 0.102, 0.002]}}]})");
  compare_stage(thrown(30, heavy));
}

TEST(self_collision, leaves_alone_what_does_not_touch) {
  const auto setup = setup_from(with(two_sheets, "0.006", "0.1"));
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    HostState s = setup.state;
    throw_sheets(setup.model, s, 1);
    StepReport report;
    backend->upload(s);
    const HostState before = backend->download();
    backend->run(Stage::self_collision, {0, 0, 0.004}, report);
    EXPECT_EQ(report.cloth_contacts, 0);
    EXPECT_EQ(backend->download().node_velocity, before.node_velocity) << backend->name();
  }
}

TEST(self_collision, conserves_momentum) {
  const auto setup = setup_from(with(two_sheets, "point: [0, -0.03, 0]", "point: [0, -0.9, 0]"));
  for (const double speed : {1.2, 30.0}) {  // contacts alone; impact zones
    SCOPED_TRACE(speed);
    HostState s = setup.state;
    throw_sheets(setup.model, s, speed);
    run_on_both(setup.model, s, {Stage::self_collision}, {0, 0, 0.004}, [&](const Backend& backend, const StepReport&) {
      const HostState after = backend.download();
      double size = 0;
      Vec3 change{0, 0, 0};
      for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
        for (int a = 0; a < 3; ++a) {
          size += setup.model.mesh.solid_mass[n] * std::abs(s.node_velocity[n][a]);
          change[a] += setup.model.mesh.solid_mass[n] * (after.node_velocity[n][a] - s.node_velocity[n][a]);
        }
      }
      for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(change[a]), allowed(backend, 1e-12, 1e-6) * size);
    });
  }
}

}  // namespace drench::test
