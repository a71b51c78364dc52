// Liquid and porous cloth exchange mass: how much, and how fast. With which momentum: porous_momentum_test.cpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "states.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// C_n in quanta, as the limiters count it.
Quanta capacity(const Model& m, std::size_t node) {
  return static_cast<Quanta>(std::floor(m.samples.node_capacity[node] / m.quantum));
}

/// A ball of liquid just above a still sheet in the plane y = 0.
struct Drop {
  static constexpr double thickness = 0.004;  // m
  SceneRun run;
  Quanta mass = 0;

  Drop(double spacing, double radius, double sheet, int nodes, const std::string& porous, double viscosity = 1e-4)
      : run(fmt::format(R"(drench: 1
time: {{step: {5}, end: 10, mode: cfl}}
domain: {{min: [-0.2, -0.05, -0.2], max: [0.2, 0.2, 0.2]}}
fluid:
  spacing: {0}
  viscosity: {9}
  sources: [{{block: {{min: [-{1}, {4}, -{1}], max: [{1}, {2}, {1}]}}}}]
cloth:
  - mesh: {{grid: {{size: [{3}, {3}], nodes: [{6}, {6}]}}}}
    dynamics: false
    thickness: {8}
    porous: {{{7}}}
)",
                        spacing, radius, 2 * radius, sheet, 0.2 * spacing, spacing, nodes, porous, thickness,
                        viscosity)) {
    HostState s = run.initial();
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3 x = s.fluid_position[i];
      if (std::hypot(x[0], x[1] - radius, x[2]) <= radius) kept.push_back(i);
    }
    keep_liquid(s, kept);
    mass = sum(s.fluid_mass);
    run.restart(s);
  }
};

}  // namespace

TEST(porous_exchange, a_drop_is_soaked_up_whole) {
  for (const double d : {0.003, 0.002}) {
    Drop drop(d, 0.008, 0.08, static_cast<int>(std::lround(0.08 / d)) + 1,
              "uptake_velocity: 1, max_saturation: 1, diffusivity: 1.0e-4");
    while (drop.run.time() < 5 && drop.run.state().fluid_count() > 0) drop.run.step();
    std::printf("drop, d = %g m: soaked up at %.3f s\n", d, drop.run.time());
    report({fmt::format("drop on a larger cloth, d = {} mm, D = 1 cm²/s: liquid that is not in the cloth", d * 1e3),
            "wetted mass = min(M, ΣC) = M, in quanta", double(std::abs(drop.mass - sum(drop.run.state().node_liquid))),
            0, "quanta"});
  }
}

TEST(porous_exchange, a_drop_wets_the_area_that_it_fills) {
  // Without diffusion the patch is full inside and dry outside, and liquid must run over full cloth to its rim. Hence
  // water's own viscosity: with 100 times of it a third of the drop still stands on the cloth, 1 mm deep, after 3 s.
  for (const double d : {0.003, 0.002}) {
    Drop drop(d, 0.0125, 0.08, static_cast<int>(std::lround(0.08 / d)) + 1,
              "uptake_velocity: 1, max_saturation: 1, diffusivity: 0", 1e-6);
    while (drop.run.time() < 3) drop.run.step();
    const HostState s = drop.run.state();
    const Model& m = drop.run.model();
    double half = 0, full = 0, any = 0, second = 0;  // m²
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double area = m.samples.node_capacity[n] / (0.6 * Drop::thickness * m.rest_density);
      const double saturation = double(s.node_liquid[n]) * m.quantum / m.samples.node_capacity[n];
      half += saturation > 0.5 ? area : 0;
      full += saturation > 0.99 ? area : 0;
      any += saturation > 0.01 ? area : 0;
      const Vec3& x = s.node_position[n];
      second += double(s.node_liquid[n]) * (x[0] * x[0] + x[2] * x[2]);
    }
    const double taken = double(sum(s.node_liquid)), volume = taken * m.quantum / m.rest_density;
    const auto of = [](double area) { return std::sqrt(area / std::numbers::pi); };
    const double radius = of(volume / (0.6 * Drop::thickness)), moment = std::sqrt(2 * second / taken);
    const double of_all = of(volume * double(drop.mass) / taken / (0.6 * Drop::thickness));
    std::printf(
        "drop, d = %g m: %.3f of it taken up, theory %.5f m (%.5f m for all of it), s > 0.01 %.5f, > 0.5 %.5f, "
        "> 0.99 %.5f, by moment %.5f\n",
        d, taken / double(drop.mass), radius, of_all, of(any), of(half), of(full), moment);
    const std::string drop_of = fmt::format("drop on a larger cloth, d = {} mm, D = 0: ", d * 1e3);
    report({drop_of + "radius of the area with s > 1/2", "√(V/(π(1−Φ)τ)), V absorbed", std::fabs(of(half) / radius - 1),
            0.05});
    report({drop_of + "radius by the wet mass's second moment, √(2⟨r²⟩)", "√(V/(π(1−Φ)τ)), V absorbed",
            std::fabs(moment / radius - 1), 0.05});
    report({drop_of + "radius of the area with s > 1/2", "√(V/(π(1−Φ)τ)), V of the drop",
            std::fabs(of(half) / of_all - 1), 0.05});
    EXPECT_GT(taken, 0.95 * double(drop.mass));
  }
}

TEST(porous_exchange, a_small_sheet_takes_what_it_holds) {
  Drop drop(0.002, 0.0125, 0.03, 16, "uptake_velocity: 1, max_saturation: 1, diffusivity: 1.0e-4");
  Quanta worst = 0;  // above C_n, at any step
  while (drop.run.time() < 3 && drop.run.state().fluid_count() > 0) {
    drop.run.step();
    const HostState s = drop.run.state();
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      worst = std::max(worst, s.node_liquid[n] - capacity(drop.run.model(), n));
  }
  const HostState s = drop.run.state();
  Quanta all = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) all += capacity(drop.run.model(), n);
  std::printf("small sheet: %.3f s, M/ΣC %.2f, %d particles left, drained %.3f of M\n", drop.run.time(),
              double(drop.mass) / double(all), int(s.fluid_count()), double(s.drained) / double(drop.mass));
  EXPECT_GT(drop.mass, 2 * all);
  EXPECT_EQ(drop.mass, sum(s.node_liquid) + sum(s.fluid_mass) + s.drained);
  report(
      {"drop on a cloth that is too small: a node above its capacity, at any step", "0", double(worst), 0, "quanta"});
  report({"drop on a cloth that is too small: share of the capacity that stays empty", "wetted mass = min(M, ΣC) = ΣC",
          std::fabs(1 - double(sum(s.node_liquid)) / double(all)), 1e-6});
}

namespace {

/// Mean saturation of the middle of a sheet under standing liquid at the given times, in units of T = (1−Φ)τ/u_a.
std::vector<double> uptake(double d, const std::vector<double>& times) {
  constexpr double T = 0.2, half = 0.032;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
domain: {{min: [-0.1, -0.1, -0.1], max: [0.1, 0.1, 0.1]}}
fluid:
  spacing: {0}
  viscosity: 1.0e-4
  sources: [{{block: {{min: [-{1}, 0, -{1}], max: [{1}, 0.016, {1}]}}}}]
cloth:
  - mesh: {{grid: {{size: [{2}, {2}], nodes: [33, 33]}}}}
    dynamics: false
    thickness: 0.0025
    porous: {{uptake_velocity: 0.0075, max_saturation: 1, diffusivity: 0}}
bodies: [{{box: {{min: [-{1}, -0.03, -{1}], max: [{1}, 0.09, {1}], inside: true}}}}]
)",
                           d, half, 2 * half));
  std::vector<double> curve;
  for (const double t : times) {
    while (run.time() < t * T - 1e-9) run.step();
    const HostState s = run.state();
    double liquid = 0, room = 0;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const Vec3& x = s.node_position[n];
      if (std::max(std::fabs(x[0]), std::fabs(x[2])) > 0.013) continue;
      liquid += double(s.node_liquid[n]) * run.model().quantum;
      room += run.model().samples.node_capacity[n];
    }
    curve.push_back(liquid / room);
  }
  return curve;
}

}  // namespace

TEST(porous_exchange, uptake_does_not_depend_on_resolution) {
  const std::vector<double> times{0.1, 0.25, 0.5, 1, 2};
  const std::vector<std::vector<double>> curves{uptake(0.008, times), uptake(0.004, times), uptake(0.002, times)};
  double coarse = 0, fine = 0, theory = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double exact = 1 - std::exp(-times[k]);
    std::printf("uptake at %.2f T: theory %.4f, d %.4f, d/2 %.4f, d/4 %.4f\n", times[k], exact, curves[0][k],
                curves[1][k], curves[2][k]);
    coarse = std::max(coarse, std::fabs(curves[0][k] / curves[1][k] - 1));
    fine = std::max(fine, std::fabs(curves[1][k] / curves[2][k] - 1));
    theory = std::max(theory, std::fabs(curves[2][k] / exact - 1));
  }
  report({"uptake_velocity, 16 mm of water standing on a cloth: m(t) at d and d/2, largest difference at 0.1 to 2 T",
          "converges", coarse, 0.1});
  report({"uptake_velocity, 16 mm of water standing on a cloth: m(t) at d/2 and d/4, largest difference", "converges",
          fine, 0.05});
  report({"uptake_velocity, 16 mm of water standing on a cloth: m(t) at d/4, largest relative error",
          "m = C (1 − exp(−u_a t/((1−Φ)τ)))", theory, 0.05});
}

namespace {

/// The liquid of a sheet in a pool, and whether it stays within its bounds, over a run of 10 s.
struct Filling {
  StageRun& run;
  const Model& m = run.setup.model;
  const Quanta total = sum(run.setup.state.fluid_mass);
  Quanta all = 0;                          // ΣC
  Quanta least = 0, most = 0;              // of the cloth's liquid in the last 5 s
  Quanta fall = 0, step = 0;               // largest in a step, until the cloth is full
  Quanta above = 0, below = 0, error = 0;  // of a node's bounds; of the ledger
  double taken = 0, full_at = -1;          // quanta, s

  explicit Filling(StageRun& of) : run(of) {
    for (std::size_t n = 0; n < m.samples.node_capacity.size(); ++n) all += capacity(m, n);
    Quanta before = 0;
    while (run.time < 10 - 1e-9) before = step_on(before);
  }

 private:
  Quanta step_on(Quanta before) {
    Quanta now = 0;
    run.step([&](Stage stage, bool done) {
      if (!done) return;
      if (stage != Stage::absorption && stage != Stage::emission && stage != Stage::ledger) return;
      const HostState s = run.backend->download();
      now = sum(s.node_liquid);
      if (stage == Stage::absorption) taken += double(now - before);
      for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
        const double most_allowed = std::floor(1.18 * m.samples.node_capacity[n] / m.quantum);
        above = std::max(above, s.node_liquid[n] - static_cast<Quanta>(most_allowed));
        below = std::max(below, -s.node_liquid[n]);
      }
      error = std::max(error, std::abs(now + sum(s.fluid_mass) + s.drained - total));
    });
    if (full_at < 0) {
      fall = std::max(fall, before - now);
      step = std::max(step, now - before);
      if (now >= all) full_at = run.time;
    }
    if (run.time > 5) {  // it goes on taking up a little for some 3 s
      least = least == 0 ? now : std::min(least, now);
      most = std::max(most, now);
    }
    return now;
  }
};

}  // namespace

TEST(porous_exchange, a_sheet_in_a_deep_pool_fills_and_stays) {
  for (const std::string material : {"uptake_velocity: 0.01", "absorption: 0.01"}) {
    StageRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 20}}
domain: {{min: [-0.1, -0.1, -0.1], max: [0.1, 0.2, 0.1]}}
fluid:
  spacing: 0.01
  viscosity: 1.0e-4
  sources: [{{block: {{min: [-0.04, 0, -0.04], max: [0.04, 0.08, 0.04]}}}}]
cloth:
  - mesh: {{grid: {{size: [0.05, 0.05], nodes: [8, 8]}}}}
    place: {{position: [0.002, 0.04, 0.001]}}
    dynamics: false
    thickness: 0.002
    porous: {{{}}}
bodies: [{{box: {{min: [-0.04, 0, -0.04], max: [0.04, 0.15, 0.04], inside: true}}}}]
)",
                             material));
    const Filling f(run);
    const double unit = 1 / double(f.all);
    std::printf(
        "pool, %s: full at %.3f s, in the last 5 s %.4f to %.4f of ΣC, largest step on the way up %.4f; taken up in "
        "all %.3f\n",
        material.c_str(), f.full_at, unit * double(f.least), unit * double(f.most), unit * double(f.step),
        unit * f.taken);
    const std::string pool = "dry cloth in a deep pool, " + material + ", 10 s: ";
    EXPECT_GT(f.full_at, 0);
    report({pool + "largest fall of the cloth's liquid until it holds ΣC", "monotone", double(f.fall), 0, "quanta"});
    report({pool + "range of its liquid in the last 5 s, over ΣC", "constant, (s_max − 1)/2",
            unit * double(f.most - f.least), 0.09});
    report({pool + "a node above s_max C or below 0, after any stage of any step", "0",
            double(std::max(f.above, f.below)), 0, "quanta"});
    report({pool + "mass budget error", "0", double(f.error), 0, "quanta"});
  }
}

}  // namespace drench::test
