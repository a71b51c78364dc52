// Stage absorption: backend against reference from identical input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "pipeline/backend.hpp"
#include "precision.hpp"
#include "quanta_sum.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

const double tolerance = double_precision ? 1e-10 : 1e-4;

/// Largest difference of two fields of vectors, relative to the largest value.
double relative_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      worst = std::max(worst, std::fabs(a[i][c] - b[i][c]));
      scale = std::max(scale, std::fabs(a[i][c]));
    }
  return worst / scale;
}

double largest_difference(const std::vector<Quanta>& a, const std::vector<Quanta>& b) {
  Quanta worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return static_cast<double>(worst);
}

/// Small particles above the sheet, larger ones below it, mixed in the arrays. A thick sheet has room: no limiter acts.
/// Half of the sheet drips, the other half is nearly dry.
void make_small_and_dripping(const Model& model, HostState& s) {
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    Vec3& x = s.fluid_position[i];
    x[1] -= 0.0805 + 0.1 * x[0] * x[2];
    if (x[1] > -0.01)
      s.fluid_mass[i] = quanta_per_particle * 52 / 1000;
    else if (i % 3 == 0)
      s.fluid_mass[i] = quanta_per_particle / 2;  // room for what is emitted
  }
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const double saturation = s.node_position[n][0] < -0.01 ? 1.08 + 0.01 * double(n % 7) : 0.1 + 0.01 * double(n % 5);
    s.node_liquid[n] = static_cast<Quanta>(saturation * model.samples.node_capacity[n] / model.quantum);
    s.node_buffered[n] = saturation > 1 ? s.node_liquid[n] / 16 : 0;
  }
}

void expect_close(const HostState& expected, const HostState& actual) {
  ASSERT_EQ(expected.fluid_id, actual.fluid_id);
  EXPECT_EQ(expected.fluid_origin, actual.fluid_origin);
  EXPECT_EQ(expected.next_id, actual.next_id);
  for (const Quanta m : actual.fluid_mass) EXPECT_GT(m, 0);
  const double quanta = tolerance * static_cast<double>(quanta_per_particle) + 64;
  EXPECT_LE(largest_difference(expected.fluid_mass, actual.fluid_mass), quanta);
  EXPECT_LE(largest_difference(expected.node_liquid, actual.node_liquid), quanta);
  EXPECT_LE(largest_difference(expected.node_buffered, actual.node_buffered), quanta);
  EXPECT_LE(relative_difference(expected.fluid_position, actual.fluid_position), tolerance);
  EXPECT_LE(relative_difference(expected.fluid_velocity, actual.fluid_velocity), tolerance);
  EXPECT_LE(relative_difference(expected.node_velocity, actual.node_velocity), tolerance);
}

}  // namespace

TEST(absorption, agrees_with_the_reference) { compare_stage({.stage = Stage::absorption, .changes = "node_liquid"}); }

TEST(absorption, particles_taken_whole_are_gone_after_emission) {
  // The reference removes them at once, the backend only at the end of emission: the two stages are compared together.
  const auto setup = setup_from(with(with(wet_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05}\n", ""),
                                     "thickness: 0.002", "thickness: 0.01"));
  const Model& model = setup.model;
  HostState before = setup.state;
  make_small_and_dripping(model, before);
  const auto reference = make_reference_backend(model);
  const auto backend = make_kokkos_backend(model);
  const StepInfo info{0, 0, model.scene.time.step};
  StepReport report;
  for (Backend* b : {reference.get(), backend.get()}) {
    b->upload(before);
    for (const Stage s : {Stage::porous_neighbors, Stage::flow_direction, Stage::absorption, Stage::emission})
      b->run(s, info, report);
  }
  const HostState expected = reference->download(), actual = backend->download();

  const std::set<std::int64_t> ids(expected.fluid_id.begin(), expected.fluid_id.end());
  std::size_t whole = 0, grown = 0;
  for (std::size_t i = 0; i < before.fluid_id.size(); ++i) {
    if (!ids.contains(before.fluid_id[i])) {
      ++whole;
      EXPECT_LT(before.fluid_mass[i], quanta_per_particle / 10);
      continue;
    }
    const std::size_t now = i - whole;  // the order stays
    ASSERT_EQ(expected.fluid_id.at(now), before.fluid_id[i]);
    if (whole > 0 && expected.fluid_mass[now] > before.fluid_mass[i]) ++grown;
  }
  EXPECT_GE(whole, 3u);
  EXPECT_GE(grown, 3u) << "particles behind an absorbed one that emission reaches";
  EXPECT_GE(expected.next_id, before.next_id + 1) << "and emission makes new ones";

  expect_close(expected, actual);
  for (const HostState* s : {&expected, &actual})
    EXPECT_EQ(sum(s->fluid_mass) + sum(s->node_liquid), sum(before.fluid_mass) + sum(before.node_liquid));
}

}  // namespace drench::test
