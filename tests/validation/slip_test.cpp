// Viscous liquid along walls and cloth that it slips on: flows of Couette and Poiseuille with Navier's condition, plug
// flow, a block on an inclined plane, and the drag of a sheet. b is the slip length, W the width between the plates, d
// the spacing.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double width = 0.1, viscosity = 1e-3, pi = 3.14159265358979323846;  // W, m; m²/s
constexpr double free_slip = std::numeric_limits<double>::infinity();
constexpr const char* source = "Navier 1823; Batchelor 1967";

std::string word(double slip) { return std::isinf(slip) ? "free" : fmt::format("{}", slip); }
std::string named(double slip) {
  return std::isinf(slip) ? "free slip" : slip == 0 ? "no slip" : fmt::format("b = {} W", slip / width);
}

/// A slab between plates at x = 0 and W, as in channel_test.cpp: its sides are free, and its ends are left out of
/// comparisons. Speeds are so small that nothing moves by a spacing. A step lasts `step_share` d²/ν.
std::string slab(int across, double step_share, double gravity, const std::string& first, const std::string& second,
                 const std::string& more = "") {
  const double d = width / across;
  return fmt::format(R"(drench: 1
time: {{step: {0}, end: 1000}}
gravity: [0, {1}, 0]
domain: {{min: [-0.05, -0.4, -0.2], max: [0.15, 0.4, 0.2]}}
fluid:
  spacing: {2}
  viscosity: {3}
  sources: [{{block: {{min: [0, -0.25, {4}], max: [{5}, 0.25, {6}]}}}}]
bodies:
  - plane: {{point: [0, 0, 0], normal: [1, 0, 0], {7}}}
  - plane: {{point: [{5}, 0, 0], normal: [-1, 0, 0], {8}}}
{9})",
                     step_share * d * d / viscosity, gravity, d, viscosity, -3 * d, width, 3 * d, first, second, more);
}

void run_for(SceneRun& run, double duration) {
  const double end = run.time() + duration;
  while (run.time() < end - 1e-9) run.step(end - run.time());
}

/// rms over the middle of the slab of v_y − exact(x), over `scale`.
double rms(const SceneRun& run, double scale, const std::function<double(double)>& exact) {
  const HostState s = run.state();
  double square = 0;
  int count = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const Vec3& x = s.fluid_position[i];
    if (std::abs(x[1]) > 0.03) continue;
    square += std::pow((s.fluid_velocity[i][1] - exact(x[0])) / scale, 2);
    ++count;
  }
  return std::sqrt(square / count);
}

/// Steady flow between a plate that moves and one that stands, with the slip lengths b0 and b1.
void couette(int across, double b0, double b1, bool keyed, double target) {
  constexpr double speed = 1e-4;  // m/s
  const std::string along =
      keyed ? fmt::format("[[0, [0, {0}, 0]], [100, [0, {0}, 0]]]", speed) : fmt::format("[0, {}, 0]", speed);
  SceneRun run(slab(across, 4, 0, fmt::format("velocity: {}, slip: {}", along, word(b0)), "slip: " + word(b1)));
  run_for(run, 3 * width * width / viscosity);
  const auto exact = [&](double x) { return std::isinf(b1) ? speed : speed * (width + b1 - x) / (width + b0 + b1); };
  const std::string at = b0 == 0 ? named(b1) + " at the fixed plate" : named(b0) + " at both plates";
  report({fmt::format("plane Couette flow, d = W/{}, {}: rms of u over U", across, at), source, rms(run, speed, exact),
          target});
}

/// Speed over g W²/ν at x/W = ξ from the middle, and at t ν/W² = τ, from rest, with slip b/W = β at both plates.
double poiseuille(double xi, double tau, double beta) {
  if (std::isinf(beta)) return tau;
  double u = 0.5 * (0.25 - xi * xi + beta);
  for (int n = 0; n < 40; ++n) {
    double low = n * pi, high = (n + 0.5) * pi;  // the root k of k tan k = 1/(2 β)
    for (int step = 0; step < 80; ++step) {
      const double k = 0.5 * (low + high);
      (2 * beta * k * std::abs(std::sin(k)) < std::abs(std::cos(k)) ? low : high) = k;
    }
    const double k = 0.5 * (low + high);
    u -= 0.5 * std::sin(k) / (k * k * k * (1 + std::sin(k) * std::cos(k) / k)) * std::cos(2 * k * xi) *
         std::exp(-4 * k * k * tau);
  }
  return u;
}

void poiseuille_flow(int across, double slip, double target) {
  constexpr double force = 1e-5, tau = 0.3;  // m/s², 1
  SceneRun run(slab(across, 0.1, force, "slip: " + word(slip), "slip: " + word(slip)));
  run_for(run, tau * width * width / viscosity);
  const double unit = force * width * width / viscosity, beta = slip / width;
  const double error = rms(run, unit * poiseuille(0, tau, beta),
                           [&](double x) { return unit * poiseuille(x / width - 0.5, tau, beta); });
  report({fmt::format("plane Poiseuille flow from rest, d = W/{}, {}: rms of u over its largest at t = 0.3 W²/ν",
                      across, named(slip)),
          source, error, target});
}

}  // namespace

TEST(slip_flow, shear_between_plates_has_navier_s_profile) {
  for (const int across : {8, 12}) {
    couette(across, 0, 0, false, 0.01);
    couette(across, 0, width / 4, false, 0.01);
    couette(across, width / 2, width / 2, across == 12, 0.01);
    couette(across, 0, free_slip, across == 12, 0.01);
  }
}

TEST(slip_flow, flow_under_a_force_has_navier_s_profile) {
  for (const int across : {8, 12})
    for (const double slip : {width / 4, width}) poiseuille_flow(across, slip, 0.02);  // no slip: channel_test.cpp
}

TEST(slip_flow, a_plug_between_free_walls_falls_freely) {
  for (const int across : {8, 12}) {
    constexpr double force = 1e-2;
    SceneRun run(slab(across, 1, -force, "slip: free", "slip: free"));
    run_for(run, 0.3 * width * width / viscosity);
    const double speed = force * run.time();
    report({fmt::format("plug between two plates with free slip, d = W/{}: rms of u over g t", across), "free fall",
            rms(run, speed, [&](double) { return -speed; }), 1e-4});
  }
}

namespace {

/// A sheet of cloth between two plates that stand, drawn through the slab in its own plane: profile on both sides, and
/// drag, N.
struct Drag {
  double rms = 0, force = 0;
};

Drag drag(int across, double slip) {
  constexpr double speed = 1e-4;
  SceneRun run(slab(across, 4, 0, "slip: no", "slip: no",
                    fmt::format(R"(
cloth:
  - mesh: {{grid: {{size: [0.7, 0.3], nodes: [57, 25]}}}}
    place: {{position: [{0}, 0, 0], rotate: {{axis: [0, 0, 1], degrees: 90}}}}
    pin: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, velocity: [0, {1}, 0]}}]
    slip: {2}
)",
                                width / 2, speed, word(slip))));
  run_for(run, width * width / viscosity);
  Drag out;
  const double half = width / 2;
  out.rms = rms(run, speed,
                [&](double x) { return std::isinf(slip) ? 0 : speed * (half - std::abs(x - half)) / (half + slip); });
  for (const Vec3& f : run.state().node_pin_force) out.force += f[1];
  return out;
}

}  // namespace

TEST(slip_flow, a_sheet_is_dragged_with_its_slip_on_both_sides) {
  for (const int across : {8, 12}) {
    const Drag held = drag(across, 0);
    report({fmt::format("cloth drawn through a slab, d = W/{}, no slip: rms of u over U", across), source, held.rms,
            0.02});
    for (const double slip : {width / 8, width / 2}) {
      const Drag some = drag(across, slip);
      const double expected = (width / 2) / (width / 2 + slip);
      report({fmt::format("cloth drawn through a slab, d = W/{}, {}: rms of u over U", across, named(slip)), source,
              some.rms, 0.02});
      report({fmt::format("cloth drawn through a slab, d = W/{}, {}: its drag over that without slip, error", across,
                          named(slip)),
              source, std::abs(some.force / held.force / expected - 1), 0.02});
    }
    report({fmt::format("cloth drawn through a slab, d = W/{}, free slip: its drag over that without slip", across),
            "0", std::abs(drag(across, free_slip).force / held.force), 0.005});  // of the pressure
  }
}

namespace {

/// A block of W² that slides down a plane tilted by 30°, between two walls with free slip: how far its middle comes
/// along the plane in 0.3 s, over the way of free sliding, which steps add up to ½ g sin α t (t + Δt).
double slide(int across, double nu, double slip) {
  constexpr double tilt = pi / 6, duration = 0.3, step = 0.002, g = 9.81;
  const double d = width / across, gx = g * std::sin(tilt), gy = -g * std::cos(tilt);
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {8}, end: 1}}
gravity: [{0}, {1}, 0]
domain: {{min: [-1, -0.1, -0.3], max: [2, 0.5, 0.3]}}
fluid:
  spacing: {2}
  viscosity: {3}
  sources: [{{block: {{min: [0, 0, {4}], max: [{5}, {5}, {6}]}}}}]
bodies:
  - plane: {{point: [0, 0, 0], normal: [0, 1, 0], slip: {7}}}
  - plane: {{point: [0, 0, {4}], normal: [0, 0, 1], slip: free}}
  - plane: {{point: [0, 0, {6}], normal: [0, 0, -1], slip: free}}
)",
                           gx, gy, d, nu, -3 * d, width, 3 * d, word(slip), step));
  run_for(run, duration);
  double middle = 0;
  const HostState s = run.state();
  for (const Vec3& x : s.fluid_position) middle += x[0] / static_cast<double>(s.fluid_position.size());
  return (middle - width / 2) / (0.5 * gx * duration * (duration + step));
}

}  // namespace

TEST(slip_flow, a_block_slides_freely_down_a_plane_with_free_slip) {
  for (const int across : {8, 12})
    for (const double nu : {1e-3, 0.01}) {
      const double way = slide(across, nu, free_slip), held = slide(across, nu, 0);
      std::printf(
          "block on a plane of 30 degrees, d = W/%d, nu = %g: %.4f of free sliding with free slip, %.4f without slip\n",
          across, nu, way, held);
      report({fmt::format(
                  "block of ν = {} m²/s on a plane tilted by 30°, d = W/{}, free slip: displacement of its centre over "
                  "½ g sin α t (t + Δt), error",
                  nu, across),
              "Newton", std::abs(way - 1), 0.005});
      EXPECT_LT(held, 0.9);
    }
}

}  // namespace drench::test
