// Bodies that float and sink: Archimedes' draught, and the first acceleration of a heavy sphere with its added mass.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double pi = std::numbers::pi;

TEST(buoyancy, calibrate) {
  const double d = 0.02, R = std::getenv("RR") ? atof(std::getenv("RR")) * d : 0.1, rho = std::getenv("RHO") ? atof(std::getenv("RHO")) : 500;
  const double half = 0.2, depth = 0.3;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {}, end: 10, mode: cfl}}
domain: {{min: [-1, -0.5, -1], max: [1, 2, 1]}}
fluid:
  spacing: {}
  viscosity: {}
  solver: {{density_error: {}, divergence_error: 1.0e-3}}
  sources: [{{block: {{min: [{}, 0, {}], max: [{}, {}, {}]}}}}]
bodies:
  - box: {{min: [{}, 0, {}], max: [{}, 1, {}], inside: true}}
  - sphere: {{center: [0, {}, 0], radius: {}, dynamic: true, density: {}}}
)", std::getenv("DT") ? atof(std::getenv("DT")) : 0.002, d, std::getenv("NU") ? atof(std::getenv("NU")) : 0.01, std::getenv("TOL") ? atof(std::getenv("TOL")) : 1e-3, -half, -half, half, depth, half, -half, -half, half, half, std::getenv("Y0") ? atof(std::getenv("Y0")) : depth, R, rho));
  const double T = std::getenv("TEND") ? atof(std::getenv("TEND")) : 1.0;
  double next = 0;
  std::printf("particles %d\n", run.initial().fluid_count());
  const double volume = run.initial().fluid_count() * d * d * d;
  double sum = 0; int n = 0;
  while (run.time() < T) {
    const StepReport r = run.step();
    if (run.time() < next) continue;
    next += T / 20;
    const HostState s = run.state();
    const double y = s.body_position[1][1];
    // level with the sphere's immersed part
    double level = volume / (4 * half * half);
    for (int k = 0; k < 50; ++k) {
      const double t = std::clamp(level - (y - R), 0.0, 2 * R);
      level = (volume + pi * t * t * (R - t / 3)) / (4 * half * half);
    }
    std::printf("t %.3f dt %.4f y %.4f level %.4f draught/R %.4f v %.4f %.4f %.4f KE %.4g it %d %d err %.2g %.2g conv %d %d clamped %d\n", run.time(), run.dt(), y, level,
                (level - (y - R)) / R, s.body_velocity[1][0], s.body_velocity[1][1], s.body_velocity[1][2], r.kinetic_energy, r.divergence_iterations, r.density_iterations, r.divergence_error,
                r.density_error, r.divergence_converged, r.density_converged, (int)r.clamped);
    if (run.time() > T / 2) sum += (level - (y - R)) / R, ++n;
  }
  std::printf("mean draught/R %.4f\n", sum / n);
}

}  // namespace
}  // namespace drench::test
