// Liquid that no lattice gives: single particles, coincident ones, and particles of 5 % mass among full ones.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "stage_compare.hpp"
#include "state/needed_fields.hpp"
#include "states.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double d = 0.02, side = 0.16;  // m

/// A closed box with water of depth 0.12 m in it.
std::string pool() {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 2, mode: cfl}}
fluid:
  spacing: {0}
  viscosity: 0.001
  sources: [{{block: {{min: [0, 0, 0], max: [{1}, 0.12, {1}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{1}, 0.4, {1}], inside: true}}}}]
)",
                     d, side);
}

/// Appends a particle at rest with `share` of a full mass.
void add(const SceneRun& run, HostState& s, const Vec3& position, double share) {
  append_particle(s, run.model(), {position, {0, 0, 0}, static_cast<Quanta>(share * quanta_per_particle)});
}

struct Outcome {
  double speed = 0;                // largest |v| on the way, m/s
  double late = 0, late_most = 0;  // largest rms and largest |v| in the second half of the time, m/s
  double compression = 0;          // mean max(0, δ − 1) of the last step
  int close = 0;                   // pairs closer than `near` at the end
  double height = 0;               // of the centre of mass at the end, m
};

/// Runs from `state` until `until`; the pipeline itself ends a run whose numbers are not finite. Every tenth step of
/// the second half of the time goes to `look`.
Outcome run_from(SceneRun& run, const HostState& state, double until, double near,
                 const std::function<void(const HostState&)>& look = {}) {
  run.restart(state);
  Outcome o;
  int steps = 0;
  while (run.time() < until) {
    o.compression = run.step().density_error;
    const HostState s = run.state();
    double mass = 0, energy = 0;
    for (std::size_t i = 0; i < s.fluid_velocity.size(); ++i) {
      const Vec3& v = s.fluid_velocity[i];
      const double speed = std::hypot(v[0], v[1], v[2]);
      o.speed = std::max(o.speed, speed);
      if (run.time() > until / 2) o.late_most = std::max(o.late_most, speed);
      mass += double(s.fluid_mass[i]);
      energy += double(s.fluid_mass[i]) * speed * speed;
    }
    if (run.time() > until / 2) o.late = std::max(o.late, std::sqrt(energy / mass));
    if (look && run.time() > until / 2 && ++steps % 10 == 0) look(s);
  }
  const HostState end = run.state();
  o.close = close_pairs(end, near);
  double mass = 0;
  for (std::size_t i = 0; i < end.fluid_position.size(); ++i) {
    mass += double(end.fluid_mass[i]);
    o.height += double(end.fluid_mass[i]) * end.fluid_position[i][1];
  }
  o.height /= mass;
  std::printf(
      "largest speed %.3f m/s; in the second half %.3f, rms %.3f; compression %.1e; %d pairs within %.2f d; height "
      "%.4f m\n",
      o.speed, o.late_most, o.late, o.compression, o.close, near / d, o.height);
  return o;
}

}  // namespace

TEST(odd_liquid, a_few_particles_fall_and_lie) {
  for (const std::size_t count : {1u, 2u, 3u, 7u, 19u}) {
    SceneRun run(pool());
    HostState s = run.initial();
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < count; ++i) which.push_back(i);
    keep_liquid(s, which);
    for (Vec3& x : s.fluid_position) x[1] += 0.1;
    const Outcome o = run_from(run, s, 1, 0.2 * d);
    EXPECT_LE(o.speed, 1.05 * std::sqrt(2 * 9.81 * 0.14));
    EXPECT_EQ(o.close, 0);
  }
}

TEST(odd_liquid, coincident_particles_part) {
  SceneRun run(pool());
  HostState s = run.initial();
  constexpr std::size_t pairs = 16;
  const std::size_t n = s.fluid_position.size();
  for (std::size_t k = 0; k < pairs; ++k) add(run, s, s.fluid_position[k * (n / pairs)], 1);
  const Outcome o = run_from(run, s, 2, 0.2 * d);
  EXPECT_EQ(o.close, 0);
  EXPECT_LE(o.compression, 2e-3);
  EXPECT_LE(o.late, 0.2) << "m/s rms";
}

TEST(odd_liquid, many_on_one_point_part) {
  // Of a compression beyond 0.2 a step corrects half, whatever density_correction is: all of it would shoot them away.
  double fastest[2];
  for (int all = 0; all < 2; ++all) {
    SceneRun run(with(pool(), "viscosity: 0.001",
                      all ? "viscosity: 0.001\n  solver: {density_correction: 1}" : "viscosity: 0.001"));
    HostState s = run.initial();
    const Vec3 middle = s.fluid_position[s.fluid_position.size() / 2];
    for (int k = 0; k < 7; ++k) add(run, s, middle, 1);
    const Outcome o = run_from(run, s, 1.5, 0.2 * d);  // after 1 s drops still fall back, and pass others closely
    EXPECT_EQ(o.close, 0);
    fastest[all] = o.speed;
  }
  EXPECT_LT(fastest[1], 1.1 * fastest[0]);
}

TEST(odd_liquid, a_squeezed_pool_parts) {
  // Compressed to 4.6 and 15.6 times water's density. With the lattice's relaxation the solve does not converge: 30 m/s
  // and more than 100 m/s.
  for (const double squeeze : {0.6, 0.4}) {
    SceneRun run(pool());
    HostState s = run.initial();
    for (Vec3& x : s.fluid_position)
      for (double& c : x) c = 0.06 + squeeze * (c - 0.06);
    run.restart(s);
    double speed = 0;
    for (int n = 0; n < 10; ++n) {
      EXPECT_TRUE(run.step().density_converged) << squeeze << ", step " << n;
      for (const Vec3& v : run.state().fluid_velocity) speed = std::max(speed, std::hypot(v[0], v[1], v[2]));
    }
    std::printf("squeezed to %.1f: %.3g m/s\n", squeeze, speed);
    EXPECT_LT(speed, squeeze > 0.5 ? 16 : 24);  // one and a half times what is measured
  }
}

// Twenty to a cell are five to a spacing's length: the kernel knows no order that fine, so they lie as at random.
// Random places in the small particles' own volume have n²/2 · (4/3)π r³ pairs within r in each cell of n. One moment's
// count varies by half, so its mean is taken. Liquid between mirrored walls simmers, and has 1.4 to 1.8 times as many.
TEST(odd_liquid, small_particles_among_full_ones) {
  constexpr int parts = 20;
  constexpr double near = 0.1 * d, until = 2;
  for (const bool extrapolates : {false, true}) {
    SceneRun run(with(pool(), "viscosity: 0.001",
                      extrapolates ? "viscosity: 0.001\n  wall_pressure: extrapolated" : "viscosity: 0.001"));
    HostState s = run.initial();
    // Every fifth particle becomes twenty of a twentieth of its mass, anywhere in its cell.
    std::mt19937 random(1);
    std::uniform_real_distribution<double> within(-0.5 * d, 0.5 * d);
    std::vector<std::size_t> which;
    std::vector<Vec3> cells;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      if (i % 5 == 0)
        cells.push_back(s.fluid_position[i]);
      else
        which.push_back(i);
    }
    keep_liquid(s, which);
    for (const Vec3& c : cells)
      for (int k = 0; k < parts; ++k)
        add(run, s, {c[0] + within(random), c[1] + within(random), c[2] + within(random)}, 1.0 / parts);
    std::vector<int> close;
    const Outcome o =
        run_from(run, s, until, near, [&](const HostState& now) { close.push_back(close_pairs(now, near)); });
    const double random_pairs =
        double(cells.size()) * parts * parts / 2 * 4 / 3 * std::numbers::pi * std::pow(near / d, 3);
    const double pairs = std::accumulate(close.begin(), close.end(), 0.0) / double(close.size());
    std::printf("%s walls: %.0f pairs, %.2f of random places\n", extrapolates ? "extrapolated" : "mirrored", pairs,
                pairs / random_pairs);
    EXPECT_LT(pairs, (extrapolates ? 1.5 : 2) * random_pairs) << "they heap up";
    EXPECT_LE(o.late, 0.2) << "m/s rms";
    EXPECT_LE(o.late_most, 1.5) << "m/s: spray from a pool at rest";
    EXPECT_NEAR(o.height, 0.06, 0.003);
  }
}

}  // namespace drench::test
