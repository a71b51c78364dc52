// Where liquid in porous cloth wants to go, and where, how fast and how much of it leaves.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double degree = std::numbers::pi / 180;

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Largest angle (degrees) between the samples' flow and `expected`; 180 where there is no flow.
double worst_angle(const HostState& s, const Vec3& expected) {
  double worst = 0;
  for (const Vec3& v : s.sample_flow_direction) {
    const double size = norm(v);
    worst = std::max(
        worst, size > 0.5 ? std::acos(std::clamp(dot(v, expected) / size / norm(expected), -1.0, 1.0)) / degree : 180);
  }
  return worst;
}

/// A still sheet parallel to a plane, at its own thickness from it. `tilt` in degrees turns the plane's normal from
/// straight up towards +x: 0 is a floor, 180 a ceiling.
HostState on_plane(double tilt, double spacing, double gravity) {
  const Vec3 n{std::sin(tilt * degree), std::cos(tilt * degree), 0};
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.001, end: 1}}
gravity: [0, {0}, 0]
domain: {{min: [-0.3, -0.3, -0.3], max: [0.3, 0.3, 0.3]}}
fluid:
  spacing: {1}
  sources: [{{block: {{min: [{2}, {3}, 0], max: [{4}, {5}, 0.01]}}}}]
cloth:
  - mesh: {{grid: {{size: [0.08, 0.08], nodes: [9, 9]}}}}
    place: {{position: [{6}, {7}, 0], rotate: {{axis: [0, 0, 1], degrees: {8}}}}}
    dynamics: false
    thickness: 0.001
    porous: {{diffusivity: 0}}
bodies: [{{plane: {{point: [0, 0, 0], normal: [{9}, {10}, 0]}}}}]
)",
                           gravity, spacing, 0.2 * n[0] - 0.005, 0.2 * n[1] - 0.005, 0.2 * n[0] + 0.005,
                           0.2 * n[1] + 0.005, 0.001 * n[0], 0.001 * n[1], -tilt, n[0], n[1]));
  run.step();
  return run.state();
}

}  // namespace

TEST(porous_emission, flow_is_tangent_on_an_incline_and_leaves_solids) {
  for (const double d : {0.01, 0.005}) {
    double incline = 0;
    for (const double tilt : {30.0, 45.0, 60.0, 75.0, 90.0}) {
      const double a = worst_angle(on_plane(tilt, d, -9.81), {std::cos(tilt * degree), -std::sin(tilt * degree), 0});
      std::printf("flow on a plane tilted by %g°, d = %g m: %.2f° off downhill\n", tilt, d, a);
      incline = std::max(incline, a);
    }
    const std::string at = fmt::format(", d = {} mm", d * 1e3);
    report({"flow direction in contact with planes of 30 to 90°" + at, "tangent, downhill", incline, 10, "degrees"});
    double away = 0;
    for (const double tilt : {0.0, 180.0})
      away = std::max(away, worst_angle(on_plane(tilt, d, -9.81), {0, std::cos(tilt * degree), 0}));
    report({"flow direction on a floor and under a ceiling" + at, "away from the plane", away, 10, "degrees"});
    double none = 0;
    for (const double tilt : {0.0, 50.0, 180.0})
      none = std::max(none, worst_angle(on_plane(tilt, d, 0), {std::sin(tilt * degree), std::cos(tilt * degree), 0}));
    report({"flow direction beside planes, no gravity" + at, "away from the plane", none, 10, "degrees"});
  }
}

TEST(porous_emission, over_a_sphere_liquid_leaves_on_the_outer_side) {
  // A sheet wrapped over a sphere of 0.1 m: its nodes are moved onto it, with their distances from the pole kept.
  constexpr double radius = 0.1, thickness = 0.002;
  for (const double d : {0.01, 0.007}) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10}}
domain: {{min: [-0.5, -0.3, -0.5], max: [0.5, 0.5, 0.5]}}
fluid:
  spacing: {}
  viscosity: 1.0e-4
  sources: [{{block: {{min: [0.45, 0.45, 0.45], max: [0.47, 0.47, 0.47]}}}}]
cloth:
  - mesh: {{grid: {{size: [0.3, 0.3], nodes: [31, 31]}}}}
    place: {{position: [0, 0.2, 0]}}
    dynamics: false
    thickness: {}
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1.18}}]
    porous: {{}}
bodies: [{{sphere: {{center: [0, 0, 0], radius: {}}}}}]
)",
                             d, thickness, radius));
    HostState start = run.initial();
    for (Vec3& x : start.node_position) {
      const double away = std::hypot(x[0], x[2]), angle = away / (radius + thickness);
      const double share = away > 0 ? (radius + thickness) * std::sin(angle) / away : 0;
      x = {share * x[0], (radius + thickness) * std::cos(angle), share * x[2]};
    }
    run.restart(start);
    std::int64_t seen = start.next_id;
    double inside = 0, all = 0, capacity = 0;
    std::map<int, int> by_angle;  // degrees from the pole
    while (run.time() < 1) {
      run.step();
      const HostState s = run.state();
      for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
        if (s.fluid_id[i] < seen) continue;
        const Vec3& x = s.fluid_position[i];
        inside += norm(x) > radius + thickness ? 0 : 1;
        all += 1;
        by_angle[static_cast<int>(std::acos(x[1] / norm(x)) / degree / 30) * 30] += 1;
      }
      seen = s.next_id;
    }
    for (const double c : run.model().samples.node_capacity) capacity += c / run.model().quantum;
    const double excess = double(sum(start.node_liquid)) - capacity,
                 left = double(sum(run.state().node_liquid)) - capacity;
    std::printf("overfull cloth on a sphere, d = %g m: %g particles, %.3f of the excess still in the cloth\n", d, all,
                left / excess);
    for (const auto& [angle, count] : by_angle)
      std::printf("  %d to %d° from the pole: %d\n", angle, angle + 30, count);
    EXPECT_GT(all, 50);
    EXPECT_GE(by_angle.size(), 3u) << "liquid leaves where the sheet is on the sphere, not only at its hem";
    report({fmt::format("overfull cloth on a sphere, d = {} mm: share of new particles on the inner side", d * 1e3),
            "liquid leaves on the outer side", inside / all, 0});
  }
}

TEST(porous_emission, blocked_on_all_sides_nothing_leaves) {
  SceneRun run(R"(drench: 1
time: {step: 0.004, end: 10}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.01
  sources: [{block: {min: [-0.02, 0.1, -0.02], max: [0.02, 0.12, 0.02]}}]
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [11, 11]}}
    dynamics: false
    thickness: 0.001
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1.15}]
    porous: {diffusivity: 0}
bodies:
  - box: {min: [-0.1, 0.001, -0.1], max: [0.1, 0.05, 0.1]}
  - box: {min: [-0.1, -0.05, -0.1], max: [0.1, -0.001, 0.1]}
)");
  for (int n = 0; n < 250; ++n) run.step();
  const HostState s = run.state();
  Quanta moved = 0, buffered = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    moved = std::max(moved, std::abs(s.node_liquid[n] - run.initial().node_liquid[n]));
    buffered += s.node_buffered[n];
  }
  EXPECT_GT(buffered, 0);
  report({"overfull cloth between two boxes, 1 s: largest change of a node's liquid", "0", double(moved), 0, "quanta"});
}

TEST(porous_emission, a_hanging_strip_drips_from_its_hem) {
  SceneRun run(R"(drench: 1
time: {step: 0.002, end: 10}
domain: {min: [-0.2, -0.5, -0.2], max: [0.2, 0.2, 0.2]}
fluid:
  spacing: 0.008
  viscosity: 1.0e-4
  sources: [{block: {min: [0.18, 0.18, 0.18], max: [0.19, 0.19, 0.19]}}]
cloth:
  - mesh: {grid: {size: [0.06, 0.2], nodes: [13, 41]}}
    place: {rotate: {axis: [1, 0, 0], degrees: 90}}
    dynamics: false
    thickness: 0.002
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1.1}]
    porous: {diffusivity: 1.0e-3, capillary_height: 0.2}
)");
  std::int64_t seen = run.initial().next_id;
  double at_hem = 0, all = 0;
  while (run.time() < 3) {
    run.step();
    const HostState s = run.state();
    for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
      if (s.fluid_id[i] < seen) continue;
      all += 1;
      at_hem += s.fluid_position[i][1] < -0.1 ? 1 : 0;
    }
    seen = s.next_id;
  }
  std::printf("hanging strip: %g new particles, %g below the hem\n", all, at_hem);
  EXPECT_GE(all, 5);
  report({"overfull strip that hangs, 3 s: share of new particles that are not below its hem", "drips from the hem",
          1 - at_hem / all, 0});
}

namespace {

/// What leaves a bowl of cloth, step by step.
struct Drips {
  static constexpr double d = 0.01, ramp = 0.02, emission_velocity = 0.5;  // m, s, m/s
  const Model& m;
  HostState before{};          // of stage emission
  double may_leave = 0;        // quanta: what is buffered when the step begins, and what becomes so in it
  double became_buffered = 0;  // quanta, in all steps
  double given = 0, rate = 0;  // quanta given back; its largest ratio to what may leave
  double kick = 0;             // m/s: the fastest new particle, relative to the cloth
  double all = 0, most = 0;    // new particles; the most in a step
  double upper_side = 0, upper_half = 0;

  void begin(const HostState& s) {
    const double part = 1 - std::exp(-emission_velocity * m.scene.time.step / d);
    may_leave = 0;
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double excess = std::max(0.0, double(s.node_liquid[n]) - m.samples.node_capacity[n] / m.quantum);
      const double kept = std::min(excess, double(s.node_buffered[n]));
      may_leave += kept + part * (excess - kept);
      became_buffered += part * (excess - kept);
    }
    before = s;
  }
  void end(const HostState& s) {
    const double out = double(sum(before.node_liquid) - sum(s.node_liquid));
    given += out;
    if (out > 0) rate = std::max({rate, out / (may_leave + 1e4), given / (became_buffered + 1e6)});
    double lowest = 0, fresh = 0;
    for (const Vec3& y : s.node_position) lowest = std::min(lowest, y[1]);
    for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
      if (s.fluid_origin[i] != static_cast<std::uint8_t>(Origin::cloth) || s.fluid_age[i] > ramp) continue;
      const Vec3& x = s.fluid_position[i];
      std::size_t n = 0;  // the nearest node
      for (std::size_t k = 1; k < s.node_position.size(); ++k)
        if (norm(minus(x, s.node_position[k])) < norm(minus(x, s.node_position[n]))) n = k;
      kick = std::max(kick, norm(minus(s.fluid_velocity[i], s.node_velocity[n])));
      if (s.fluid_id[i] < before.next_id) continue;
      fresh += 1;
      upper_side += x[1] > s.node_position[n][1] ? 1 : 0;
      upper_half += s.node_position[n][1] > 0.5 * lowest ? 1 : 0;
    }
    all += fresh;
    most = std::max(most, fresh);
  }
};

}  // namespace

TEST(porous_emission, a_bowl_drips_from_its_belly_and_gently) {
  // Water poured on a sheet that is held along its edges, as in scenes/water_on_cloth.yaml.
  StageRun run(R"(drench: 1
time: {step: 0.002, end: 10}
domain: {min: [-0.3, -0.6, -0.3], max: [0.3, 0.4, 0.3]}
fluid:
  spacing: 0.01
  viscosity: 1.0e-4
  sources: [{jet: {center: [0, 0.12, 0], radius: 0.03, velocity: [0, -1, 0], end: 0.4}}]
cloth:
  - mesh: {grid: {size: [0.3, 0.3], nodes: [21, 21]}}
    areal_density: 0.2
    thickness: 0.001
    stretch: 300
    bend: 1.0e-4
    damping: 2
    pin: [{edges: true}]
    porous: {emission_velocity: 0.5, emission_ramp: 0.02}
)");
  Drips drips{run.setup.model};
  while (run.time < 1.5)
    run.step([&](Stage stage, bool done) {
      if (stage != Stage::emission) return;
      const HostState s = run.backend->download();
      done ? drips.end(s) : drips.begin(s);
    });
  std::printf(
      "bowl: %g new particles, at most %g in a step, %.2f of all that became buffered given back, fastest %.3f m/s\n",
      drips.all, drips.most, drips.given / drips.became_buffered, drips.kick);
  EXPECT_GT(drips.all, 50);
  const std::string bowl = "water poured on a cloth held at its edges, 1.5 s: ";
  report({bowl + "share of new particles on its upper side", "leaves at the lowest part", drips.upper_side / drips.all,
          0});
  report({bowl + "share of new particles in the upper half of the bowl", "leaves at the lowest part",
          drips.upper_half / drips.all, 0.5});
  report({bowl + "released mass over the buffered mass that may leave, worst per step and in total", "at most 1",
          drips.rate, 1});
  report({bowl + "fastest new particle in its first 20 ms, relative to the cloth", "d/T + 2 g T of the ramp",
          drips.kick, Drips::d / Drips::ramp + 2 * 9.81 * Drips::ramp, "m/s"});
  report({bowl + "most new particles in a step of 2 ms", "no bursts", drips.most, 5, "particles"});
}

}  // namespace drench::test
