// A column of water in a closed box comes to rest: pressure, compression, energy and the load on the box.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, height = 0.5, spacing = 0.025, width = 0.5, step = 0.004;  // m/s², m, m, m, s

/// (dW/dr)/r of the cubic spline, 1/m⁵ (src/stages/kernel.hpp).
double slope(double r, double h) {
  const double q = r / h, sigma = 8 / (3.14159265358979323846 * std::pow(h, 5));
  if (q >= 1) return 0;
  return q <= 0.5 ? sigma * 6 * (3 * q - 2) : -sigma * 6 * (1 - q) * (1 - q) / q;
}

/// Load on the box (N, downward) in a step, from its pressures and the positions at its beginning: the reaction
/// Σ_b Σ_i m_i V_b κ_i ∇W_ib of src/stages/divergence.hpp, of both solves and over all samples. The floor's samples
/// alone do not carry the weight: the walls' lowest ones push the lowest layer down, those in the corner push it up.
double load_on_box(const Model& model, const HostState& start, const HostState& end) {
  double load = 0;
  const double h = model.support;
  for (std::size_t i = 0; i < start.fluid_position.size(); ++i) {
    const Vec3& x = start.fluid_position[i];
    const double kappa = end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i];
    if (kappa == 0 || (x[0] > h && x[0] < width - h && x[2] > h && x[2] < width - h && x[1] > h)) continue;
    const double factor = -kilograms(model, start.fluid_mass[i]) * kappa;
    for (std::size_t b = 0; b < start.boundary_position.size(); ++b) {
      const Vec3& y = start.boundary_position[b];
      const double r = std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
      if (r < h) load += (getenv("MIR") ? atof(getenv("MIR")) : 2) * factor * start.boundary_volume[b] * slope(r, h) * (x[1] - y[1]);
    }
  }
  return load;
}

struct Rest {
  double pressure_inside = 0, pressure_all = 0;  // rms of the time mean's error over ρ g H
  double compression = 0;                        // mean of max(0, δ − 1), its time mean
  double load = 0;                               // |mean load on the box / weight − 1|
  double growth = 0;  // largest kinetic energy of the last period over that of the one before
};

/// Three periods of 0.75 s of a 0.5 m column; means over the last one.
Rest settle(double tolerance) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 3}}
fluid:
  spacing: {1}
  viscosity: 0.01
  solver: {{density_error: {2}, divergence_error: {2}}}
  sources: [{{block: {{min: [0, 0, 0], max: [{3}, {4}, {3}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{3}, 0.7, {3}], inside: true}}}}]
)",
                           step, spacing, tolerance, width, height));
  const std::size_t n = run.initial().fluid_position.size();
  const double weight = gravity * static_cast<double>(n) * run.model().particle_mass;
  const int period = static_cast<int>(std::lround(0.75 / step));
  std::vector<double> kappa(n, 0), depth(n, 0);
  Rest rest;
  double energy[3] = {0, 0, 0};
  for (int k = 0; k < 2 * period; ++k) {
    double& largest = energy[k / period];
    largest = std::max(largest, run.step().kinetic_energy);
  }
  HostState start = run.state();
  double clamped = 0, its = 0, itd = 0, nc = 0;
  for (int k = 0; k < period; ++k) {
    const StepReport rep = run.step();
    its += rep.density_iterations; itd += rep.divergence_iterations; nc += !rep.density_converged;
    energy[2] = std::max(energy[2], rep.kinetic_energy);
    clamped += static_cast<double>(rep.clamped) / period;
    const HostState end = run.state();
    rest.load += load_on_box(run.model(), start, end) / weight / period;
    for (std::size_t i = 0; i < n; ++i) {
      kappa[i] += (end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i]) / period;
      depth[i] += start.fluid_position[i][1] / period;
      rest.compression += std::max(0.0, end.fluid_density_ratio[i] - 1) / static_cast<double>(n) / period;
    }
    start = end;
  }
  printf("its %g %g not %g of %d\n", its/period, itd/period, nc, period);
  double mean = 0;
  for (const double y : depth) mean += y / static_cast<double>(n);
  const double surface = 2 * mean;  // the walls keep the liquid a little off, so that it stands higher than it was cut
  std::size_t inside = 0;
  if (getenv("PROFILE")) {
    std::vector<double> pk(40), py(40), pn(40), pc(40);
    for (std::size_t i = 0; i < n; ++i) { int l = std::min(39, int(start.fluid_position[i][1] / spacing)); pk[l] += kappa[i]; py[l] += depth[i]; pn[l] += 1; }
    for (int l = 0; l < 22; ++l) if (pn[l]) printf("layer %d n %g y %.4f k/gH %.4f exact %.4f\n", l, pn[l], py[l]/pn[l], pk[l]/pn[l]/gravity/surface, 1-py[l]/pn[l]/surface);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& x = start.fluid_position[i];
    const double error = std::pow(kappa[i] / (gravity * surface) - (1 - depth[i] / surface), 2);
    rest.pressure_all += error / static_cast<double>(n);
    const double h = 2 * spacing;
    if (x[0] < h || x[0] > width - h || x[2] < h || x[2] > width - h || x[1] < h) continue;
    rest.pressure_inside += error;
    ++inside;
  }
  rest.pressure_inside = std::sqrt(rest.pressure_inside / static_cast<double>(inside));
  rest.pressure_all = std::sqrt(rest.pressure_all);
  rest.load = std::fabs(rest.load - 1);
  rest.growth = energy[2] / energy[1];
  std::printf(
      "TOL %g: surface %.4f m; largest energies of the periods %.3e %.3e %.3e J; %.2f particles a step put back "
      "by the box\n",
      tolerance, surface, energy[0], energy[1], energy[2], clamped);
  return rest;
}

}  // namespace

// Why the pressure misses its target today. (1) A particle's κ is the multiplier of its own density constraint and walls
// have none: a wall sample answers with κ_i where a neighbour answers with κ_i + κ_j. A layer at a wall must therefore
// come closer and carry more: single particles in edges and corners, pressed onto the box's surface, up to 3.5 times the
// right pressure; some 15 of 1280 are put back by advection's failsafe in each step, and what it does to them is in no
// pressure (the load misses by that, in double). (2) Farther in, the sums of 30 neighbours at h = 2 d leave the gradient
// 4 % off.
TEST(hydrostatic, a_column_comes_to_rest) {
  const Rest rest = settle(1e-5);
  const std::string column = "hydrostatic column 0.5 m, d = H/20, tolerance 1e-5: ", theory = "p = ρ g (H − z)";
  report({column + "rms of mean p over ρgH, all particles", theory, rest.pressure_all, 0.02, "1", 0.45});
  report(
      {column + "rms of mean p over ρgH, farther than h from the box", theory, rest.pressure_inside, 0.02, "1", 0.07});
  report({column + "mean compression", "0", rest.compression, 1e-3});
  report({column + "mean load on the box over the weight, − 1", "weight", rest.load, 0.002, "1", 0.01});
  report({column + "largest kinetic energy of the third 0.75 s over the second", "decays", rest.growth, 1, "1", 2});
}

// The default tolerance, a mean compression of 1e-3, is more than a step's gravity does to an unsupported column
// (g Δt²/H = 3e-4), so that the pressure of a single step is any number from 0 to 3 times the right one and the liquid
// never stands still. The means are right.
TEST(hydrostatic, a_column_at_default_tolerances) {
  const Rest rest = settle(getenv("TOL") ? atof(getenv("TOL")) : 1e-3);
  const std::string column = "hydrostatic column 0.5 m, d = H/20, tolerance 1e-3: ", theory = "p = ρ g (H − z)";
  report(
      {column + "rms of mean p over ρgH, farther than h from the box", theory, rest.pressure_inside, 0.02, "1", 0.09});
  report({column + "mean compression", "0", rest.compression, 1e-3});
  report({column + "mean load on the box over the weight, − 1", "weight", rest.load, 0.002, "1", 0.03});
  report({column + "largest kinetic energy of the third 0.75 s over the second", "decays", rest.growth, 1, "1", 3});
}

}  // namespace drench::test
