// Squeezed fabric: what a pad between plates keeps, and what a twisted towel does.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stage_run.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double thickness = 0.003, compression = 3000, compressibility = 0.7, solid_fraction = 0.2;

/// A soaked pad whose middle two plates squeeze to `room` of its thickness from 0.2 s on, and leave at `open` (s).
std::string pad(double room, double open) {
  const double gap = room * thickness, apart = 2.5 * thickness;  // from its middle
  return fmt::format(R"(drench: 1
time: {{step: 0.005, end: 10}}
domain: {{min: [-0.2, -0.2, -0.2], max: [0.2, 0.2, 0.2]}}
fluid: {{spacing: 0.006, viscosity: 1.0e-5}}
bodies:
  - box: {{min: [-0.0255, {0}, -0.0255], max: [0.0255, {1}, 0.0255],
        offset: [[0, [0, 0, 0]], [0.2, [0, {2}, 0]], [{3}, [0, {2}, 0]], [{4}, [0, 0, 0]]]}}
  - box: {{min: [-0.0255, {5}, -0.0255], max: [0.0255, {6}, 0.0255],
        offset: [[0, [0, 0, 0]], [0.2, [0, {7}, 0]], [{3}, [0, {7}, 0]], [{4}, [0, 0, 0]]]}}
cloth:
  - mesh: {{grid: {{size: [0.08, 0.08], nodes: [21, 21]}}}}
    pin: [{{edges: true}}]
    thickness: {8}
    compression: {9}
    areal_density: 0.4
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{solid_fraction: {10}, diffusivity: 2.0e-4, capillary_height: 0.3, compressibility: {11}}}
)",
                     -apart - 0.03, -apart, apart - gap, open, open + 0.2, apart, apart + 0.03, gap - apart, thickness,
                     compression, solid_fraction, compressibility);
}

/// Nodes in the middle of the plates.
bool pressed(const Vec3& x) { return std::abs(x[0]) < 0.017 && std::abs(x[2]) < 0.017; }

struct Kept {
  double share = 0, pressure = 0;  // of what the pores hold at rest; Pa
};
Kept kept(const Model& m, const HostState& s) {
  double liquid = 0, room = 0;
  Kept mean;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    if (!pressed(m.mesh.rest_position[n])) continue;
    liquid += double(s.node_liquid[n]) * m.quantum;
    room += m.samples.node_capacity[n];
    mean.pressure += m.samples.node_capacity[n] * s.node_contact_pressure[n];
  }
  return {liquid / room, mean.pressure / room};
}

void run_until(SceneRun& run, double end) {
  while (run.time() < end - 1e-9) run.step(end - run.time());
}

}  // namespace

/// (τ(p)/τ − Φ)/(1 − Φ) of its capacity, at three pressures.
TEST(squeezing, pad_between_plates_keeps_what_its_thickness_leaves) {
  for (const double room : {0.8, 0.6, 0.45}) {
    SCOPED_TRACE(room);
    SceneRun run(pad(room, 9));
    run_until(run, 3.5);
    const HostState s = run.state();
    const Kept end = kept(run.model(), s);
    const double pressure = compression * (1 - room) / (room - (1 - compressibility));
    const double expected = (room - solid_fraction) / (1 - solid_fraction);
    report({.what = fmt::format("soaked pad between plates at {:.2g} of its thickness: error of what it keeps", room),
            .reference = "(τ(p)/τ − Φ)/(1 − Φ) of its capacity, Bogaty et al. 1953",
            .measured = std::abs(end.share / expected - 1),
            .target = 0.1});
    EXPECT_NEAR(end.pressure, pressure, 0.1 * pressure);
  }
}

TEST(squeezing, released_pad_takes_up_again) {
  SceneRun run(pad(0.5, 1.5));
  run_until(run, 1.5);
  const double squeezed = kept(run.model(), run.state()).share;
  run_until(run, 4);
  const HostState s = run.state();
  EXPECT_LT(kept(run.model(), s).pressure, 1);
  EXPECT_GT(kept(run.model(), s).share, squeezed + 0.1);  // wicked back from around the plates
}

/// A soaked towel that is held at both ends and twisted.
TEST(squeezing, wrung_towel_lets_go_of_its_water) {
  constexpr double width = 0.16, length = 0.6, tau = 0.003, turn_time = 0.25;
  constexpr int turns = 6;
  const double rate = 180 / turn_time;  // degrees/s, of each end
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10, mode: cfl}}
domain: {{min: [-0.6, -0.4, -0.3], max: [0.6, 0.3, 0.3]}}
fluid: {{spacing: 0.01, viscosity: 1.0e-5}}
cloth:
  - mesh: {{grid: {{size: [{0}, {1}], nodes: [31, 9]}}}}
    thickness: {2}
    compression: 2000
    areal_density: 0.4
    stretch: 2000
    damping: 3
    self_collision: true
    pin:
      - box: {{min: [-1, -1, -1], max: [-0.299, 1, 1]}}
        offset: [[0, [0, 0, 0]], [1.5, [0.025, 0, 0]]]
        spin: {{axis: [1, 0, 0], degrees_per_second: [[0, {3}], [1.5, {3}], [1.501, 0]]}}
      - box: {{min: [0.299, -1, -1], max: [1, 1, 1]}}
        offset: [[0, [0, 0, 0]], [1.5, [-0.025, 0, 0]]]
        spin: {{axis: [-1, 0, 0], degrees_per_second: [[0, {3}], [1.5, {3}], [1.501, 0]]}}
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{solid_fraction: 0.15, capillary_height: 0.12, compressibility: 0.8}}
)",
                           length, width, tau, rate));
  const auto liquid = [&] {
    double sum = 0;
    for (const Quanta m : run.state().node_liquid) sum += kilograms(run.model(), m);
    return sum;
  };
  const double soaked = liquid();
  double last = soaked, rise = 0;
  for (int turn = 1; turn <= turns; ++turn) {
    run_until(run, turn * turn_time);
    const double now = liquid();
    std::printf("turn %d: %.3f\n", turn, now / soaked);
    rise = std::max(rise, (now - last) / soaked);
    last = now;
  }
  run_until(run, turns * turn_time + 0.5);
  last = liquid();
  report({.what = "soaked towel after six turns: share of its water that it keeps",
          .reference = "more than half is wrung out",
          .measured = last / soaked,
          .target = 0.5});
  report({.what = "soaked towel that is wrung: largest gain of water in a turn, of all",
          .reference = "0: it falls with the turns",
          .measured = rise,
          .target = 0});
}

}  // namespace drench::test
