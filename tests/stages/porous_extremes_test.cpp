// The stages of porous cloth where sizes are extreme: backend against reference from identical input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stage_compare.hpp"

namespace drench::test {
namespace {

struct Extreme {
  const char* name;
  std::string scene;
  std::function<void(Model&)> resolve;
  std::function<void(const Model&, HostState&)> prepare;
};

/// Saturations around 1 with some of it buffered, so that absorption, emission and diffusion all have something to do.
void drips(const Model& m, HostState& s) {
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const double part = 0.7 + 0.45 * double(n % 11) / 11;
    s.node_liquid[n] = static_cast<Quanta>(part * m.samples.node_capacity[n] / m.quantum);
    s.node_buffered[n] = part > 1 ? s.node_liquid[n] / 20 : 0;
    const double k = double(n);
    s.node_velocity[n] = {0.1 * std::sin(12.9898 * k + 1), 0.1 * std::sin(78.233 * k + 2),
                          0.1 * std::sin(37.719 * k + 3)};
  }
}

/// A hundred particles around the sample in the middle of a coarse sheet, on both of its sides, a third of them small.
void heap(const Model& m, HostState& s) {
  drips(m, s);
  const Vec3 at = m.samples.rest_position[static_cast<std::size_t>(m.samples.count() / 2)];
  ASSERT_GE(s.fluid_position.size(), 100u);
  for (std::size_t i = 0; i < 100; ++i) {
    const double k = double(i), turn = 2.39996 * k, flat = 2 * (k + 0.5) / 100 - 1, r = m.spacing * (0.3 + 0.01 * k);
    s.fluid_position[i] = {at[0] + r * std::sqrt(1 - flat * flat) * std::cos(turn), at[1] + r * flat,
                           at[2] + r * std::sqrt(1 - flat * flat) * std::sin(turn)};
    if (i % 3 == 0) s.fluid_mass[i] = quanta_per_particle / (i % 2 == 0 ? 11 : 3);
  }
}

/// One particle close to a sheet whose mesh is much finer than the liquid.
void lonely(const Model& m, HostState& s) {
  drips(m, s);
  visit_fields(s, [&](std::string_view name, auto& array) {
    if (name.starts_with("fluid_")) array.resize(std::min<std::size_t>(1, array.size()));
  });
  s.fluid_position[0] = {0.003, 0.4 * m.spacing, 0.002};
  s.fluid_mass[0] = quanta_per_particle / 2;
  int near = 0;
  for (const Vec3& x : m.samples.rest_position)
    near += std::hypot(x[0] - 0.003, x[1] - 0.4 * m.spacing, x[2] - 0.002) < m.support ? 1 : 0;
  EXPECT_GE(near, 100);
}

/// Every seventh triangle has shrunk to a point at rest: no area, and no capacity.
void collapse(Model& m) {
  SampleSet& s = m.samples;
  s.node_capacity.assign(s.node_capacity.size(), 0.0);
  for (std::size_t p = 0; p < s.capacity.size(); ++p) {
    if (s.triangle[p] % 7 == 3) s.area[p] = s.capacity[p] = 0;
    for (std::size_t k = 0; k < 3; ++k)
      s.node_capacity[static_cast<std::size_t>(m.mesh.triangle[static_cast<std::size_t>(s.triangle[p])][k])] +=
          s.weight[p][k] * s.capacity[p];
  }
}

/// Their nodes coincide too, which moves the neighbours of these triangles.
void collapse_nodes(const Model& m, HostState& s) {
  drips(m, s);
  for (std::size_t t = 3; t < m.mesh.triangle.size(); t += 14)
    for (int k = 1; k < 3; ++k)
      s.node_position[static_cast<std::size_t>(m.mesh.triangle[t][static_cast<std::size_t>(k)])] =
          s.node_position[static_cast<std::size_t>(m.mesh.triangle[t][0])];
}

/// All triangles around some nodes hold nothing.
void no_room(Model& m) {
  SampleSet& s = m.samples;
  std::vector<bool> dead(s.node_capacity.size(), false);
  for (std::size_t n = 0; n < dead.size(); n += 5) dead[n] = true;
  s.node_capacity.assign(s.node_capacity.size(), 0.0);
  for (std::size_t p = 0; p < s.capacity.size(); ++p) {
    const auto& nodes = m.mesh.triangle[static_cast<std::size_t>(s.triangle[p])];
    for (const Index n : nodes)
      if (dead[static_cast<std::size_t>(n)]) s.capacity[p] = 0;
    for (std::size_t k = 0; k < 3; ++k)
      s.node_capacity[static_cast<std::size_t>(nodes[k])] += s.weight[p][k] * s.capacity[p];
  }
}

std::vector<Extreme> extremes() {
  // The reservoir's targets would follow the capacities that some of these take away.
  const std::string held = "    hold_saturation: [{box: {min: [-0.2, -1, 0.12], max: [0.2, 1, 0.2]}, value: 0.6}]\n";
  const std::string scene = with(wet_scene(), held, "");
  const std::string coarse = with(scene, "size: [0.3, 0.3], nodes: [9, 9]", "size: [0.12, 0.12], nodes: [5, 5]");
  return {
      {"100 particles on one sample", coarse, {}, heap},
      {"1 particle over 100 samples",
       with(scene, "size: [0.3, 0.3], nodes: [9, 9]", "size: [0.12, 0.12], nodes: [31, 31]"),
       {},
       lonely},
      {"node capacity 0", scene, no_room, drips},
      {"almost solid", with(scene, "porous: {", "porous: {solid_fraction: 0.9999, "), {}, drips},
      {"solid", with(scene, "porous: {", "porous: {solid_fraction: 0.9999999, "), {}, drips},
      {"degenerate triangles", scene, collapse, collapse_nodes},
  };
}

}  // namespace

class porous_extremes : public testing::TestWithParam<Stage> {};

TEST_P(porous_extremes, agree_with_the_reference) {
  for (const Extreme& e : extremes()) {
    SCOPED_TRACE(e.name);
    const Stage stage = GetParam();
    const bool solid = std::string(e.name) == "solid";  // a node holds fewer quanta than the limiters keep free
    std::string changes = stage == Stage::emission ? "node_buffered" : "node_liquid";
    if (stage == Stage::flow_direction) changes = "sample_flow_direction";
    if (solid && stage != Stage::flow_direction) changes = "";
    compare_stage({.stage = stage,
                   .scene = e.scene,
                   .steps_before = 2,
                   .resolve = e.resolve,
                   .prepare = e.prepare,
                   .changes = changes});
  }
}

INSTANTIATE_TEST_SUITE_P(stages, porous_extremes,
                         testing::Values(Stage::flow_direction, Stage::absorption, Stage::emission, Stage::diffusion),
                         [](const auto& stage) { return std::string(name_of(stage.param)); });

}  // namespace drench::test
