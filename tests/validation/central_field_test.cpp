// A drop in a field of force −Ω² x swings about the sphere as an ellipsoid.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "states.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double rate = 10, radius = 0.1, swing = 0.15;  // 1/s, m, 1: initial A over Ω

/// Semi-axes a_k (over the radius) and their rates of stretching A_k = (da_k/dt)/a_k of an ellipsoid of ideal liquid
/// in the field: u_k = A_k x_k, p = P (1 − Σ x_k²/a_k²), dA_k/dt + A_k² = Π/a_k² − Ω² with Σ A_k = 0 (Dirichlet; the
/// plane case is Monaghan & Rafiee 2013).
struct Ellipsoid {
  std::array<double, 3> a{1, 1, 1}, stretch{swing * rate, -swing*rate, 0};
};

Ellipsoid slope(const Ellipsoid& e) {
  double squares = 0, inverse = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    squares += e.stretch[k] * e.stretch[k];
    inverse += 1 / (e.a[k] * e.a[k]);
  }
  const double pressure = (squares + 3 * rate * rate) / inverse;
  Ellipsoid s;
  for (std::size_t k = 0; k < 3; ++k) {
    s.a[k] = e.stretch[k] * e.a[k];
    s.stretch[k] = pressure / (e.a[k] * e.a[k]) - rate * rate - e.stretch[k] * e.stretch[k];
  }
  return s;
}

/// Time of the n-th zero of f, linearly between samples.
class ZeroCounter {
 public:
  void add(double t, double f) {
    if (count_ < 9 && last_ * f < 0) zero_[count_++] = t - (t - time_) * f / (f - last_);
    time_ = t;
    last_ = f;
  }
  int count() const { return count_; }
  /// From the first zero to the fifth: two periods.
  double period() const { return (zero_[4] - zero_[0]) / 2; }

 private:
  double time_ = 0, last_ = 0, zero_[9] = {};
  int count_ = 0;
};

double theory() {
  Ellipsoid e;
  ZeroCounter zeros;
  constexpr double dt = 1e-4;
  for (int n = 0; zeros.count() < 5; ++n) {
    zeros.add(n * dt, std::log(e.a[0] / e.a[1]));
    Ellipsoid middle = e;
    const Ellipsoid first = slope(e);
    for (std::size_t k = 0; k < 3; ++k) {
      middle.a[k] += 0.5 * dt * first.a[k];
      middle.stretch[k] += 0.5 * dt * first.stretch[k];
    }
    const Ellipsoid second = slope(middle);
    for (std::size_t k = 0; k < 3; ++k) {
      e.a[k] += dt * second.a[k];
      e.stretch[k] += dt * second.stretch[k];
    }
  }
  return zeros.period();
}

struct Swing {
  double period = 0;  // s
  double decay = 0;   // 1: largest |ln a/b| after two periods over the first
};

Swing measure(double d) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 10}}
gravity: [0, 0, 0]
field: {{rate: [{1}, {1}, {1}]}}
domain: {{min: [-1, -1, -1], max: [1, 1, 1]}}
fluid:
  spacing: {2}
  viscosity: 0
  sources: [{{block: {{min: [-0.12, -0.12, -0.12], max: [0.12, 0.12, 0.12]}}}}]
)",
                           0.02 * d / radius, rate, d));
  HostState state = run.initial();
  for (std::size_t i = state.fluid_position.size(); i-- > 0;) {
    const Vec3 x = state.fluid_position[i];
    state.fluid_velocity[i] = {swing * rate * x[0], -swing * rate * x[1], 0};
    if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] > radius * radius) state.fluid_mass[i] = 0;
  }
  // Out of every array of the particles, with those of mass 0.
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < state.fluid_mass.size(); ++i)
    if (state.fluid_mass[i] > 0) which.push_back(i);
  keep_liquid(state, which);
  run.restart(state);
  ZeroCounter zeros;
  double first = 0, later = 0;
  const double rough = 2 * std::numbers::pi / (std::sqrt(2.0) * rate);
  while (zeros.count() < 5 && run.time() < 4 * rough) {
    run.step();
    const HostState s = run.state();
    double xx = 0, yy = 0;
    for (const Vec3& x : s.fluid_position) {
      xx += x[0] * x[0];
      yy += x[1] * x[1];
    }
    const double aspect = 0.5 * std::log(xx / yy);  // = ln(a/b)
    zeros.add(run.time(), aspect);
    if (run.time() < 0.6 * rough) first = std::max(first, std::fabs(aspect));
    if (run.time() > 2.0 * rough) later = std::max(later, std::fabs(aspect));
  }
  return {zeros.count() < 5 ? 0 : zeros.period(), later / first};
}

}  // namespace

TEST(central_field, a_drop_swings_with_the_period_of_theory) {
  const double small = 2 * std::numbers::pi / (std::sqrt(2.0) * rate), exact = theory();
  std::printf("period of small swings %.5f s, of this swing %.5f s\n", small, exact);
  for (const int across : {6, 8}) {
    const Swing s = measure(radius / across);
    std::printf(
        "R = %d d: period %.5f s, %.3f of small swings', %.3f of this swing's; a swing two periods later is "
        "%.2f of the first\n",
        across, s.period, s.period / small, s.period / exact, s.decay);
    report({fmt::format("drop in −Ω² x, R = {} d: error of the period of its aspect ratio", across), "2π/(√2 Ω)",
            std::fabs(s.period / small - 1), 0.03});
  }
}

}  // namespace drench::test
