#include <fmt/format.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include "quanta_sum.hpp"
#include "stage_run.hpp"
#include "validation.hpp"
namespace drench::test {
TEST(diag, fall) {
  const double d = atof(getenv("D")), width = 0.024, start = 0.048, end = atof(getenv("END")), dt = atof(getenv("DT"));
  const char* extra = getenv("X") ? getenv("X") : "";
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {6}, end: 10}}
domain: {{min: [-0.1, -0.06, -0.1], max: [0.1, 0.2, 0.1]}}
fluid:
  spacing: {0}
  viscosity: 1.0e-6
  sources: [{{block: {{min: [-{1}, 0, -{1}], max: [{1}, {2}, {1}]}}}}]
cloth:
  - mesh: {{grid: {{size: [{3}, {3}], nodes: [{4}, {4}]}}}}
    dynamics: false
    thickness: 0.001
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{uptake_velocity: 0.01, diffusivity: 0, permeability: 1.0193679918450562e-10{5}}}
bodies: [{{box: {{min: [-{1}, -0.2, -{1}], max: [{1}, 0.2, {1}], inside: true}}}}]
)", d, width / 2, start, width, std::lround(width / d) + 1, extra, dt));
  const Model& m = run.model();
  const double h = m.support, g = 9.81;
  const auto W = [&](double r) { const double q = r / h; return 8 / (M_PI * h * h * h) * (q >= 1 ? 0 : q <= 0.5 ? 6 * (q * q * q - q * q) + 1 : 2 * std::pow(1 - q, 3)); };
  double next = 0.05;
  double fluxsum = 0; int steps = 0;
  double lasth = 0;
  while (run.time() < end - 1e-9) {
    run.step();
    { const HostState s = run.state(); double f = 0; for (double u : s.sample_flux) f += std::fabs(u) / double(s.sample_flux.size()); fluxsum += f; ++steps; }
    if (run.time() < next - 1e-9) continue;
    next += 0.05;
    const HostState s = run.state();
    double volume = 0, small = 0, above = 0;
    for (std::size_t i = 0; i < s.fluid_mass.size(); ++i)
      if (s.fluid_position[i][1] > 0) { volume += double(s.fluid_mass[i]) * m.quantum / m.rest_density; above += 1; small += s.fluid_mass[i] < quanta_per_particle / 2; }
    const double hh = volume / (width * width);
    double F[2]{}, B[4]{}, wB[4]{};
    const auto dW = [&](double r) { const double q = r / h; return 8 / (M_PI * h * h * h * h) * (q >= 1 ? 0 : q <= 0.5 ? 6 * q * (3 * q - 2) : -6 * (1 - q) * (1 - q)); };
    for (std::size_t p = 0; p < s.sample_flux.size(); ++p) {
      const Vec3 x = m.samples.rest_position[p];
      for (std::size_t i = 0; i < s.fluid_mass.size(); ++i) {
        const Vec3& y = s.fluid_position[i];
        const int side = y[1] > 0;
        const double ax = y[0] - x[0], ay = y[1] - x[1] + (side ? 0.5 : -0.5) * d, az = y[2] - x[2], r = std::sqrt(ax * ax + ay * ay + az * az), mi = double(s.fluid_mass[i]) * m.quantum;
        const double r0 = std::sqrt(std::pow(y[0]-x[0],2)+std::pow(y[1]-x[1],2)+std::pow(y[2]-x[2],2));
        const double kappa = s.fluid_kappa_density[i] + s.fluid_kappa_divergence[i];
        if (side && r0 < h) { const double mm = mi / m.particle_mass; const int c = mm > 0.9 ? 0 : mm > 0.5 ? 1 : mm > 0.125 ? 2 : 3; B[c] += mi * W(r0) * (kappa + g * y[1]); wB[c] += mi * W(r0); }
        if (r >= h || r0 >= h) continue;
        F[side] += 2 * std::max(1.0, s.fluid_density_ratio[i] - 0.1) * mi * s.sample_volume[p] * kappa * dW(r) * ay / r;
      }
    }
    std::printf("  load head up %.2f low %.2f mm; VW mean by mass: >0.9 %.2f (%.2f), >0.5 %.2f (%.2f), >0.125 %.2f (%.2f), less %.2f (%.2f)\n", -F[1] / (1000 * g * width * width) * 1e3, F[0] / (1000 * g * width * width) * 1e3,
      B[0]/wB[0]/g*1e3, wB[0]/(wB[0]+wB[1]+wB[2]+wB[3]), B[1]/wB[1]/g*1e3, wB[1]/(wB[0]+wB[1]+wB[2]+wB[3]), B[2]/wB[2]/g*1e3, wB[2]/(wB[0]+wB[1]+wB[2]+wB[3]), B[3]/wB[3]/g*1e3, wB[3]/(wB[0]+wB[1]+wB[2]+wB[3]));
    double A[2]{}, P[2]{}, flux = 0, K[2]{}; int n = 0;
    std::size_t samples = s.sample_flux.size();
    for (std::size_t p = 0; p < samples; ++p) {
      const Vec3 x = m.samples.rest_position[p];
      if (std::max(std::fabs(x[0]), std::fabs(x[2])) > 0.006) continue;
      ++n; flux += std::fabs(s.sample_flux[p]);
      double a[2]{}, b[2]{}, c[2]{};
      for (std::size_t i = 0; i < s.fluid_mass.size(); ++i) {
        const Vec3& y = s.fluid_position[i];
        const double r = std::sqrt(std::pow(y[0]-x[0],2)+std::pow(y[1]-x[1],2)+std::pow(y[2]-x[2],2));
        if (r >= h) continue;
        const int side = y[1] > 0;
        const double w = double(s.fluid_mass[i]) * m.quantum / m.rest_density * W(r);
        const double kappa = s.fluid_kappa_density[i] + s.fluid_kappa_divergence[i];
        a[side] += w; b[side] += w * std::max(0.0, kappa + g * y[1]); c[side] += w * s.fluid_kappa_divergence[i];
      }
      for (int k = 0; k < 2; ++k) { A[k] += a[k]; P[k] += b[k] / std::max(a[k], 0.1); K[k] += c[k] / std::max(a[k], 0.1); }
    }
    std::printf("t %.3f h %.2f mm (theory %.2f), K h %.2f mm/s; mean flux since %.2f, -dh/dt %.2f; now centre flux %.2f; A up %.3f low %.3f; head up %.2f low %.2f mm (div %.2f %.2f); above %g, small %g, below %g, cloth %.4f\n",
      run.time(), hh * 1e3, start * std::exp(-run.time()) * 1e3, hh * 1e3, fluxsum / steps * 1e3, lasth > 0 ? (lasth - hh) / 0.05 * 1e3 : 0, flux / n * 1e3, A[1] / n, A[0] / n, P[1] / n / g * 1e3, P[0] / n / g * 1e3, K[1] / n / g * 1e3, K[0] / n / g * 1e3, above, small, double(s.fluid_mass.size()) - above, double(sum(s.node_liquid)) * m.quantum / (0.6 * 0.001 * 1000 * width * width));
    lasth = hh; fluxsum = 0; steps = 0;
  }
}
}
