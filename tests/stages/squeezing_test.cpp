// Stage squeezing: pressure on fabric between solids and between layers, against the reference and against statics.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {
namespace {

constexpr double thickness = 0.002, compression = 4000, compressibility = 0.6, solid_fraction = 0.3;

/// Sheets one above the other, at their thickness, on a floor; no two edges are parallel.
std::string stack(int layers, double gravity = 9.81) {
  std::string text = fmt::format(R"(drench: 1
time: {{step: 0.004, end: 1}}
gravity: [0, {}, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid: {{spacing: 0.02}}
bodies: [{{plane: {{point: [0, {}, 0], normal: [0, 1, 0]}}}}]
cloth:
)",
                                 -gravity, -thickness);
  for (int k = 0; k < layers; ++k)
    text += fmt::format(R"(  - name: layer_{0}
    mesh: {{grid: {{size: [0.2, 0.2], nodes: [{1}, {2}]}}}}
    place: {{position: [{3}, {4}, 0.001], rotate: {{axis: [0, 1, 0], degrees: {5}}}}}
    areal_density: 0.4
    thickness: {6}
    compression: {7}
    self_collision: true
    porous: {{solid_fraction: {8}, compressibility: {9}}}
)",
                        k, 8 + k % 2, 9 - k % 2, 0.001 * k, k * thickness, 1 + 0.7 * k, thickness, compression,
                        solid_fraction, compressibility);
  return text;
}

/// A sheet of fabric between two boxes that leave `gap` (m) for both of its sides.
std::string between_plates(double gap) {
  return fmt::format(R"(drench: 1
time: {{step: 0.004, end: 1}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid: {{spacing: 0.02}}
bodies:
  - box: {{min: [-0.3, -0.1, -0.3], max: [0.3, {0}, 0.3]}}
  - box: {{min: [-0.3, {1}, -0.3], max: [0.3, 0.1, 0.3]}}
cloth:
  - mesh: {{grid: {{size: [0.2, 0.2], nodes: [7, 6]}}}}
    settle: 1
    thickness: {2}
    compression: {3}
    porous: {{solid_fraction: {4}, compressibility: {5}}}
)",
                     -gap / 2, gap / 2, thickness, compression, solid_fraction, compressibility);
}

}  // namespace

TEST(squeezing, between_plates_agrees_with_the_reference) {
  compare_stage({.stage = Stage::squeezing,
                 .scene = between_plates(0.0028),
                 .steps_before = 0,
                 .changes = "node_contact_pressure"});
}

TEST(squeezing, of_a_sheet_in_motion_agrees_with_the_reference) {
  compare_stage({.stage = Stage::squeezing,
                 .scene = with(stack(1), "self_collision: true", "self_collision: false"),
                 .steps_before = 3,
                 .prepare =
                     [](const Model&, HostState& s) {
                       for (std::size_t n = 0; n < s.node_position.size(); ++n)
                         for (int a = 0; a < 3; ++a)
                           s.node_position[n][a] = float(s.node_position[n][a] + 2e-5 * noise(n, a));
                     },
                 .changes = "node_contact_pressure"});
}

/// The law of thickness and pressure is one: what the gap leaves is what the pressure says.
TEST(squeezing, between_plates_follows_the_fabrics_compression) {
  const double room = 0.6;
  const drench::Setup setup = setup_from(between_plates(room * 2 * thickness));
  const double expected = compression * (1 - room) / (room - (1 - compressibility));
  const std::vector<Stage> often(40, Stage::squeezing);
  run_on_both(setup.model, setup.state, often, {0, 0, 0.05, 0}, [&](Backend& backend, const StepReport&) {
    const HostState state = backend.download();
    for (const double p : state.node_contact_pressure) EXPECT_NEAR(p, expected, 1e-3 * expected);
  });
}

/// Where the sheet begins the step inside one of the plates the force grows from where both hold it (Eq. 26a).
TEST(squeezing, inside_a_plate_counts_from_where_both_hold) {
  struct Case {
    double depth, comes_out;  // of the thickness; in the step
  };
  const double room = 0.42, dt = 0.05;
  for (const Case& c : {Case{0.1, 0.3}, Case{0.15, 0.1}, Case{0.15, 0.02}}) {
    drench::Setup setup = setup_from(between_plates(room * 2 * thickness));
    setup.model.cloths[0].release = c.comes_out * thickness / dt;
    for (Vec3& x : setup.state.node_position) x[1] = -(room + c.depth) * thickness;
    const double begins = (1 + c.comes_out - c.depth) / 2;
    const double expected = compression * (begins - room) / (room - (1 - compressibility));
    const std::vector<Stage> often(40, Stage::squeezing);
    run_on_both(setup.model, setup.state, often, {0, 0, dt, 0}, [&](Backend& backend, const StepReport&) {
      for (const double p : backend.download().node_contact_pressure)
        EXPECT_NEAR(p, expected, 2e-3 * compression) << c.depth << ' ' << c.comes_out;
    });
  }
}

TEST(squeezing, of_crumpled_layers_agrees_with_the_reference) {
  drench::Setup setup = setup_from(stack(3));
  HostState& s = setup.state;
  for (std::size_t n = 0; n < s.node_position.size(); ++n)
    for (int a = 0; a < 3; ++a)
      s.node_position[n][a] = float(s.node_position[n][a] + (a == 1 ? 3e-5 : 2e-4) * noise(n, a));
  std::vector<std::vector<double>> found;
  run_on_both(setup.model, s, {Stage::self_collision, Stage::squeezing}, {0, 0, 0.004, 0},
              [&](Backend& backend, const StepReport&) { found.push_back(backend.download().node_contact_pressure); });
  double most = 0;
  for (const double p : found[0]) most = std::max(most, p);
  ASSERT_GT(most, 1);
  const double allowed = (double_precision ? 1e-6 : 2e-3) * most;
  for (std::size_t n = 0; n < found[0].size(); ++n) EXPECT_NEAR(found[0][n], found[1][n], allowed) << n;
}

/// The mean over a layer's thickness of what it carries: half of its own weight and all that of the layers above.
TEST(squeezing, of_layers_that_lie_on_a_floor_is_their_weight) {
  constexpr int layers = 4;
  const drench::Setup setup = setup_from(stack(layers));
  const std::vector<double>& capacity = setup.model.samples.node_capacity;
  run_on_both(setup.model, setup.state, {Stage::self_collision, Stage::squeezing}, {0, 0, 10, 0},
              [&](Backend& backend, const StepReport&) {
                const HostState state = backend.download();
                double force[layers] = {}, area[layers] = {};
                for (std::size_t n = 0; n < capacity.size(); ++n) {
                  const double own = capacity[n] / (setup.model.rest_density * (1 - solid_fraction) * thickness);
                  force[setup.model.mesh.node_cloth[n]] += own * state.node_contact_pressure[n];
                  area[setup.model.mesh.node_cloth[n]] += own;
                }
                for (int k = 0; k < layers; ++k) {
                  const double expected = 0.4 * 9.81 * (layers - 1 - k + 0.5);
                  EXPECT_NEAR(force[k] / area[k], expected, 0.05 * expected) << "layer " << k;
                }
              });
}

}  // namespace drench::test
