// Drops without gravity: the pressure inside (Laplace), the period in which they oscillate (Rayleigh), what the forces
// conserve; and drops on a plate and on cloth that they stick to (Young and Dupré).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "validation.hpp"

namespace drench::test {
namespace {

using std::numbers::pi;

constexpr double spacing = 0.01, tension = 0.07, density = 1000, viscosity = 5e-5,
                 step = 0.02;  // m, N/m, kg/m³, m²/s, s
constexpr double volume = spacing * spacing * spacing;
constexpr double area_share = 0.78;  // β of docs/theory/surface_tension.md

std::string scene(double box) {
  return fmt::format(R"(drench: 1
time: {{step: {0}, end: 100}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: {1}
  viscosity: {2}
  surface_tension: {3}
  solver: {{density_error: 1.0e-4, divergence_error: 1.0e-4, max_iterations: 500}}
  sources: [{{block: {{min: [-{4}, -{4}, -{4}], max: [{4}, {4}, {4}]}}}}]
)",
                     step, spacing, viscosity, tension, box);
}

/// Keeps the particles for which `inside(x)`.
template <class Inside>
HostState cut(HostState s, const Inside& inside) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    if (inside(s.fluid_position[i])) kept.push_back(i);
  const auto keep = [&](auto& values) {
    for (std::size_t k = 0; k < kept.size(); ++k) values[k] = values[kept[k]];
    values.resize(kept.size());
  };
  keep(s.fluid_position), keep(s.fluid_velocity), keep(s.fluid_mass), keep(s.fluid_id), keep(s.fluid_age);
  keep(s.fluid_origin), keep(s.fluid_density_ratio), keep(s.fluid_kappa_density), keep(s.fluid_kappa_divergence);
  return s;
}

/// A sphere of radius R, at rest, cut out of the lattice that the scene starts with.
HostState sphere(const SceneRun& run, double radius) {
  return cut(run.initial(), [&](const Vec3& x) { return std::hypot(x[0], x[1], x[2]) < radius; });
}

/// Of the sphere with the same volume, m.
double radius_of(const HostState& s) {
  return std::cbrt(3 * volume * static_cast<double>(s.fluid_position.size()) / (4 * pi));
}

double rayleigh_period(double radius) { return 2 * pi * std::sqrt(density * std::pow(radius, 3) / (8 * tension)); }

Vec3 centre(const HostState& s) {
  Vec3 c{0, 0, 0};
  for (const Vec3& x : s.fluid_position)
    for (std::size_t a = 0; a < 3; ++a) c[a] += x[a] / static_cast<double>(s.fluid_position.size());
  return c;
}

/// (dW/dr)/r of the cubic spline, 1/m⁵ (src/stages/kernel.hpp).
double kernel_derivative(double r, double h) {
  const double q = r / h, sigma = 8 / (pi * std::pow(h, 5));
  if (q >= 1) return 0;
  return q <= 0.5 ? sigma * 6 * (3 * q - 2) : -sigma * 6 * (1 - q) * (1 - q) / q;
}

/// Pressure in the drop's core, Pa, from the virial −1/(6 V) Σ_i Σ_j F_ij·x_ij of both solves' pressure and of the
/// cohesion: the field `pressure` less the internal pressure. The area term is left out, whose normals vanish there.
double core_pressure(const HostState& s, double h) {
  const Vec3 c = centre(s);
  const double radius = radius_of(s), cohesion = (1 - area_share) * tension / (31.0 / 560 * h);
  double virial = 0, count = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
    const Vec3& x = s.fluid_position[i];
    if (std::hypot(x[0] - c[0], x[1] - c[1], x[2] - c[2]) > radius - 1.5 * h) continue;
    ++count;
    for (std::size_t j = 0; j < s.fluid_position.size(); ++j) {
      const Vec3& y = s.fluid_position[j];
      const double r = std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
      if (j == i || r >= h) continue;
      const double kappa = s.fluid_kappa_density[i] + s.fluid_kappa_density[j] + s.fluid_kappa_divergence[i] +
                           s.fluid_kappa_divergence[j];
      virial += volume * volume * (cohesion - density * kappa) * kernel_derivative(r, h) * r * r;
    }
  }
  return virial / (6 * volume * count);
}

/// ln of the ratio of the second moments along and across z: 2 ln of the aspect ratio of an ellipsoid.
double elongation(const HostState& s) {
  const Vec3 c = centre(s);
  Vec3 m{0, 0, 0};
  for (const Vec3& x : s.fluid_position)
    for (std::size_t a = 0; a < 3; ++a) m[a] += (x[a] - c[a]) * (x[a] - c[a]);
  return std::log(2 * m[2] / (m[0] + m[1]));
}

/// ω of e^{−γt} (a cos ωt + b sin ωt) + c, the least squares over all ω, γ, a, b, c.
double frequency(const std::vector<double>& t, const std::vector<double>& q, double expected) {
  double best = INFINITY, found = 0;
  for (double w = 0.6; w < 1.5; w += 0.005)
    for (double g = 0; g < 0.5; g += 0.01) {
      std::array<std::array<double, 4>, 3> m{};
      const auto terms = [&](std::size_t k) {
        const double e = std::exp(-g * expected * t[k]), p = w * expected * t[k];
        return std::array<double, 4>{e * std::cos(p), e * std::sin(p), 1, q[k]};
      };
      for (std::size_t k = 0; k < t.size(); ++k) {
        const auto f = terms(k);
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 4; ++j) m[i][j] += f[i] * f[j];
      }
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t r = 0; r < 3; ++r) {
          if (r == i) continue;
          const double z = m[r][i] / m[i][i];
          for (std::size_t j = i; j < 4; ++j) m[r][j] -= z * m[i][j];
        }
      double error = 0;
      for (std::size_t k = 0; k < t.size(); ++k) {
        const auto f = terms(k);
        double e = f[3];
        for (std::size_t i = 0; i < 3; ++i) e -= m[i][3] / m[i][i] * f[i];
        error += e * e;
      }
      if (error < best) best = error, found = w * expected;
    }
  return found;
}

struct Oscillation {
  double laplace = 0;   // core pressure over 2 σ/R, its mean
  double rayleigh = 0;  // ω² over 8 σ/(ρ R³)
};

/// A sphere settles for half a period; then it is stretched by 1.2 and let go for 1.5 periods.
Oscillation oscillate(double radii) {
  SceneRun run(scene((radii + 1) * spacing));
  run.restart(sphere(run, radii * spacing));
  const double radius = radius_of(run.state()), period = rayleigh_period(radius), h = run.model().support;
  while (run.time() < 0.5 * period) run.step();
  HostState s = run.state();
  for (Vec3& x : s.fluid_position)
    x = {x[0] * std::pow(1.2, -1. / 3), x[1] * std::pow(1.2, -1. / 3), x[2] * std::pow(1.2, 2. / 3)};
  for (Vec3& v : s.fluid_velocity) v = {0, 0, 0};
  s.time = 0;
  s.step = 0;
  run.restart(s);
  std::vector<double> times, shapes;
  double pressure = 0, samples = 0;
  for (int n = 0; run.time() < 1.5 * period; ++n) {
    run.step();
    s = run.state();
    times.push_back(run.time());
    shapes.push_back(elongation(s));
    if (n % 10 == 0 && run.time() > 0.5 * period) {
      pressure += core_pressure(s, h);
      ++samples;
    }
  }
  const double omega = 2 * pi / period, found = frequency(times, shapes, omega);
  return {pressure / samples / (2 * tension / radius), found * found / (omega * omega)};
}

/// `reached`: of ω², where its target is missed.
void compare_with_theory(double radii, const Reached& reached) {
  const Oscillation o = oscillate(radii);
  std::printf("R = %g d: pressure %.3f of 2 sigma/R, omega^2 %.3f of 8 sigma/(rho R^3)\n", radii, o.laplace,
              o.rayleigh);
  report({fmt::format("drop, R = {} d: pressure inside, error", radii), "Laplace 2σ/R", std::abs(o.laplace - 1), 0.1});
  report({fmt::format("drop, R = {} d: ω² of the second mode, error", radii), "Rayleigh 8σ/(ρR³)",
          std::abs(o.rayleigh - 1), 0.15, "1", reached,
          "A drop of 900 particles oscillates one and a half times before it comes to rest: rounding alone makes its "
          "ω² 0.81 to "
          "0.98 of theory."});
}

/// Height of the centre of mass of a spherical cap with contact angle θ over the radius of the sphere of its volume.
double cap_height(double theta) {
  const double c = std::cos(theta), h = 1 - c;  // of the cap of radius 1
  const double scale = std::cbrt(0.25 * (2 + c) * h * h);
  return (0.75 * (2 - h) * (2 - h) / (3 - h) - c) / scale;
}

/// The liquid that a drop on a wall begins as, in spacings: half its sides and its height; `ball`, if above 0, is the
/// radius of a ball around the height `centre` that is cut from it.
struct Start {
  double half = 6, height = 8;
  double ball = 0, centre = 0;
};

std::string plate(double adhesion) {
  return fmt::format("bodies: [{{plane: {{point: [0, 0, 0], normal: [0, 1, 0], adhesion: {}}}}}]\n", adhesion);
}

/// A level sheet: a dry one that stands still, or a wet one, full of liquid, that moves between its pinned edges and is
/// too stiff to wrap the drop.
std::string sheet(double adhesion, bool wet) {
  const char* const still = "    dynamics: false\n";
  const char* const soaked =
      "    pin: [{edges: true}]\n    bend: 0.1\n    stretch: 5000\n    porous: {}\n"
      "    initial_saturation: [{box: {min: [-9, -9, -9], max: [9, 9, 9]}, value: 1}]\n";
  return fmt::format(
      "cloth:\n  - mesh: {{grid: {{size: [0.5, 0.5], nodes: [26, 26]}}}}\n    thickness: 0.002\n    adhesion: {}\n{}",
      adhesion, wet ? soaked : still);
}

/// cos θ of a drop of some 1100 particles on a wall, from the height of its centre of mass.
double contact_cosine(const std::string& wall, const Start& from) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 100}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: {1}
  viscosity: 4.0e-4
  surface_tension: {2}
  solver: {{density_error: 1.0e-4, divergence_error: 1.0e-4, max_iterations: 500}}
  sources: [{{block: {{min: [-{3}, 0, -{3}], max: [{3}, {4}, {3}]}}}}]
{5})",
                           step, spacing, tension, from.half * spacing, from.height * spacing, wall));
  const double ball = from.ball * spacing, centre_height = from.centre * spacing;
  const HostState start = cut(
      run.initial(), [&](const Vec3& x) { return ball <= 0 || std::hypot(x[0], x[1] - centre_height, x[2]) < ball; });
  run.restart(start);
  const double radius = radius_of(start), period = rayleigh_period(radius);
  double height = 0, samples = 0;
  while (run.time() < 4 * period) {
    run.step();
    if (run.time() < 3 * period) continue;
    const HostState s = run.state();
    EXPECT_EQ(s.fluid_position.size(), start.fluid_position.size());
    height += centre(s)[1] / radius;
    ++samples;
  }
  height /= samples;
  double low = 0.05, high = pi - 1e-3;
  while (high - low > 1e-4) (cap_height(0.5 * (low + high)) < height ? low : high) = 0.5 * (low + high);
  return std::cos(low);
}

struct Work {
  double share;  // of σ
  const char* letters;
};

/// From a ball that touches the wall the contact line advances, from a film it recedes. Both should end at the same
/// angle. A film would jump off a wall with w = σ/4, as drops do; there a cap with an angle of 120° recedes.
void compare_sides(const std::string& what, const Work& w, const std::string& wall) {
  const Start ball{7, 13, 6.5, 6.5}, film{9.5, 3}, cap{9, 13, 6.83, 3.41};
  const double expected = w.share - 1;
  const std::string drop = fmt::format("drop on {}, w = {}: ", what, w.letters);
  const double advanced = contact_cosine(wall, ball), receded = contact_cosine(wall, w.share < 0.5 ? cap : film);
  std::printf("%s, w = %g sigma: cos theta %.3f advancing, %.3f receding (Young and Dupre %g)\n", what.c_str(), w.share,
              advanced, receded, expected);
  report({drop + "cos θ of a drop that spreads, error", "Young–Dupré w/σ − 1", std::abs(advanced - expected), 0.1});
  report({drop + "cos θ of a film that recedes, error", "Young–Dupré w/σ − 1", std::abs(receded - expected), 0.1});
  report({drop + "cos θ from the two sides, difference", "0, the wall is smooth", std::abs(advanced - receded), 0.1});
}

}  // namespace

TEST(drop, of_six_spacings_has_the_pressure_and_the_period_of_its_tension) {
  compare_with_theory(6, {0.209, 0.209, 0.19});
}
TEST(drop, of_eight_spacings_has_the_pressure_and_the_period_of_its_tension) { compare_with_theory(8, {}); }

TEST(drop, finds_its_angle_from_both_sides) {
  for (const Work& w : {Work{0.25, "σ/4"}, Work{0.5, "σ/2"}, Work{1, "σ"}, Work{1.5, "3σ/2"}})
    compare_sides("a plate", w, plate(w.share * tension));
}

TEST(drop, finds_its_angle_on_cloth) {
  for (const Work& w : {Work{0.5, "σ/2"}, Work{1.5, "3σ/2"}}) {
    compare_sides("dry cloth", w, sheet(w.share * tension, false));
    compare_sides("wet cloth that moves", w, sheet(w.share * tension, true));
  }
}

TEST(drop, conserves_momentum_and_angular_momentum) {
  SceneRun run(scene(0.06));  // a cube of 1728 particles, whose edges and corners set it in motion
  const auto momenta = [](const HostState& s) {
    std::array<double, 8> m{};  // linear, angular, and the sums of their terms' magnitudes
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3 &x = s.fluid_position[i], &v = s.fluid_velocity[i];
      for (std::size_t a = 0; a < 3; ++a) {
        m[a] += v[a];
        m[3 + a] += x[(a + 1) % 3] * v[(a + 2) % 3] - x[(a + 2) % 3] * v[(a + 1) % 3];
      }
      m[6] += std::hypot(v[0], v[1], v[2]);
      m[7] += std::hypot(v[0], v[1], v[2]) * std::hypot(x[0], x[1], x[2]);
    }
    return m;
  };
  // Off its axes, so that nothing cancels by symmetry; unequal masses are the business of surface_tension_test.cpp.
  run.restart(cut(run.initial(), [](const Vec3& x) { return x[0] + 0.5 * x[1] - 0.3 * x[2] < 0.04; }));
  for (int n = 0; n < 5; ++n) run.step();
  double linear = 0, angular = 0;
  auto before = momenta(run.state());
  for (int n = 0; n < 100; ++n) {
    run.step();
    const auto now = momenta(run.state());
    linear = std::max(linear, std::hypot(now[0] - before[0], now[1] - before[1], now[2] - before[2]) / now[6]);
    angular = std::max(angular, std::hypot(now[3] - before[3], now[4] - before[4], now[5] - before[5]) / now[7]);
    before = now;
  }
  const double target = double_precision ? 1e-12 : 1e-6;
  report({"drop: change of momentum per step over the sum of its magnitudes", "conserved", linear, target});
  report({"drop: change of angular momentum per step over the sum of its magnitudes", "conserved", angular, target});
}

}  // namespace drench::test
