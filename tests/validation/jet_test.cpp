// A jet carries exactly what its nozzle says and leaves it without a burst.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double spacing = 0.01, density = 1000;  // m, kg/m³

struct Jet {
  double mass = 0;     // largest |supplied − ρ A v t| over a particle's mass
  double crowded = 0;  // largest density ratio − 1 of particles less than 0.1 m from the nozzle
  double speed = 0;    // largest ||v| / |v0| − 1| in free flight without gravity
};

/// A jet without gravity from 0.013 s to `end`, for half a second.
Jet pour(double radius, double speed, double end) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.0037, end: 1, mode: cfl}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [5, 1, 1]}}
fluid:
  spacing: {}
  sources: [{{jet: {{center: [0, 0, 0], radius: {}, velocity: [{}, 0, 0], start: 0.013, end: {}}}}}]
)",
                           spacing, radius, speed, end));
  Jet jet;
  const double flow = density * std::numbers::pi * radius * radius * speed;
  while (run.time() < 0.5) {
    run.step();
    const HostState s = run.state();
    const double expected = flow * std::clamp(run.time() - 0.013, 0.0, end - 0.013);
    jet.mass = std::max(jet.mass, std::fabs(kilograms(run.model(), s.supplied) - expected) / run.model().particle_mass);
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3& v = s.fluid_velocity[i];
      jet.speed = std::max(jet.speed, std::fabs(std::hypot(v[0], v[1], v[2]) / speed - 1));
      if (s.fluid_position[i][0] < 0.1) jet.crowded = std::max(jet.crowded, s.fluid_density_ratio[i] - 1);
    }
  }
  return jet;
}

}  // namespace

TEST(jet, carries_its_mass_and_does_not_burst) {
  Jet worst;
  for (const double radius : {0.5, 1.7, 4.5}) {
    for (const double speed : {0.5, 3.0}) {
      const Jet jet = pour(radius * spacing, speed, speed > 1 ? 0.3 : 10.0);
      std::printf("radius %.1f d, %.1f m/s: mass %.3f particles, density ratio 1 %+.4f, speed %.4f\n", radius, speed,
                  jet.mass, jet.crowded, jet.speed);
      worst = {std::max(worst.mass, jet.mass), std::max(worst.crowded, jet.crowded), std::max(worst.speed, jet.speed)};
    }
  }
  report({"emitters: largest difference of the mass from ρ A v t over a particle's mass", "ρ A v t", worst.mass, 1});
  report({"emitters: largest density ratio near the nozzle, − 1", "no burst", worst.crowded, 0.05});
  report({"emitters: largest change of the speed in free flight over the speed", "no burst", worst.speed, 0.02});
}

}  // namespace drench::test
