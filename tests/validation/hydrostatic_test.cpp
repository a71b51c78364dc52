// A column of water in a closed box comes to rest: pressure, compression, energy and the load on the box.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "scene/smoothing_kernel.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, height = 0.5, width = 0.5, step = 0.004;  // m/s², m, m, s

/// Load on the box (N, downward) in a step, from its pressures and the positions at its beginning: the reaction
/// Σ_b Σ_i 2 m_i V_b κ_i ∇W_ib of src/stages/divergence.hpp, of both solves and over all samples. The floor's samples
/// alone do not carry the weight: the walls' lowest ones push the lowest layer down, those in the corner push it up.
double load_on_box(const Model& model, const HostState& start, const HostState& end) {
  double load = 0;
  const double h = model.support;
  for (std::size_t i = 0; i < start.fluid_position.size(); ++i) {
    const Vec3& x = start.fluid_position[i];
    const double kappa = end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i];
    if (kappa == 0 || (x[0] > h && x[0] < width - h && x[2] > h && x[2] < width - h && x[1] > h)) continue;
    const double factor = -2 * kilograms(model, start.fluid_mass[i]) * kappa;
    for (std::size_t b = 0; b < start.boundary_position.size(); ++b) {
      const Vec3& y = start.boundary_position[b];
      const double r = std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
      if (r < h) load += factor * start.boundary_volume[b] * kernel_slope(model.scene.fluid.kernel, r, h) * (x[1] - y[1]);
    }
  }
  return load;
}

struct Rest {
  double pressure = 0, layers = 0;  // rms of the time mean's error over ρ g H: of particles, of means over layers
  double compression = 0;                        // mean of max(0, δ − 1), its time mean
  double load = 0;                               // |mean load on the box / weight − 1|
  double iterations = 0, most_iterations = 0;
  double growth = 0;  // largest kinetic energy of the last period over that of the one before
};

/// Three periods of 0.75 s of a column of 0.5 × 0.5 × 0.5 m; means over the last one.
Rest settle(double tolerance, int across = 20, const std::string& kernel = "cubic") {
  const double spacing = height / across;
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 3}}
fluid:
  spacing: {1}
  kernel: {5}
  viscosity: 0.01
  solver: {{density_error: {2}, divergence_error: {2}}}
  sources: [{{block: {{min: [0, 0, 0], max: [{3}, {4}, {3}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{3}, 0.7, {3}], inside: true}}}}]
)",
                           step, spacing, tolerance, width, height, kernel));
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
  double clamped = 0;
  for (int k = 0; k < period; ++k) {
    const StepReport r = run.step();
    energy[2] = std::max(energy[2], r.kinetic_energy);
    clamped += static_cast<double>(r.clamped) / period;
    rest.iterations += double(r.density_iterations) / period;
    rest.most_iterations = std::max<double>(rest.most_iterations, r.density_iterations);
    const HostState end = run.state();
    rest.load += load_on_box(run.model(), start, end) / weight / period;
    for (std::size_t i = 0; i < n; ++i) {
      kappa[i] += (end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i]) / period;
      depth[i] += start.fluid_position[i][1] / period;
      rest.compression += std::max(0.0, end.fluid_density_ratio[i] - 1) / static_cast<double>(n) / period;
    }
    start = end;
  }
  double mean = 0;
  for (const double y : depth) mean += y / static_cast<double>(n);
  const double surface = 2 * mean;  // the walls keep the liquid a little off, so that it stands higher than it was cut
  std::map<int, std::array<double, 2>> layer;  // Σ error, count of particles
  for (std::size_t i = 0; i < n; ++i) {
    const double error = kappa[i] / (gravity * surface) - (1 - depth[i] / surface);
    rest.pressure += error * error / static_cast<double>(n);
    auto& l = layer[static_cast<int>(depth[i] / spacing)];
    l[0] += error;
    l[1] += 1;
  }
  for (const auto& [_, l] : layer) rest.layers += l[0] * l[0] / l[1] / static_cast<double>(n);
  rest.pressure = std::sqrt(rest.pressure);
  rest.layers = std::sqrt(rest.layers);
  rest.load = std::fabs(rest.load - 1);
  rest.growth = energy[2] / energy[1];
  std::printf(
      "%s, d = H/%d, tolerance %g: surface %.4f m; largest energies of the periods %.3e %.3e %.3e J; %.2f particles a "
      "step put back by the box; density iterations %.1f, at most %g\n",
      kernel.c_str(), across, tolerance, surface, energy[0], energy[1], energy[2], clamped, rest.iterations,
      rest.most_iterations);
  return rest;
}

}  // namespace

// The pressure misses its target for two reasons. (1) A wall is a mirror across but not along itself: particles at the
// side walls, 19 % of these, transmit a fifth less of the vertical stress, and the others carry it: the layers' means are
// 3 to 4 % too high. (2) κ of a single particle scatters by 4 % with its 30 neighbours at h = 2 d.
TEST(hydrostatic, a_column_comes_to_rest) {
  const Rest rest = settle(1e-5), coarse = settle(1e-5, 10);
  const std::string column = "hydrostatic column 0.5 m, d = H/20, tolerance 1e-5: ", theory = "p = ρ g (H − z)";
  report({column + "rms of the particles' mean p over ρgH", theory, rest.pressure, 0.02, "1", 0.055});
  report({column + "rms of the layers' mean p over ρgH", theory, rest.layers, 0.02, "1", 0.03});
  report({"the same with d = H/10", theory, coarse.layers, 0.02, "1", 0.06});
  report({column + "mean compression", "0", rest.compression, 1e-3});
  report({column + "mean load on the box over the weight, − 1", "weight", rest.load, 0.002, "1", 0.005});
  report({column + "largest kinetic energy of the third 0.75 s over the second", "decays", rest.growth, 1});
  report({column + "most density iterations", "max_iterations 100", rest.most_iterations, 99});
  std::printf("order of the layers' error in d: %.2f, of the particles' %.2f\n", std::log2(coarse.layers / rest.layers),
              std::log2(coarse.pressure / rest.pressure));
}

// The default tolerance, a mean compression of 1e-3, is more than a step's gravity does to an unsupported column
// (g Δt²/H = 3e-4), so that the pressure of a single step is any number from 0 to 3 times the right one and the liquid
// never stands still. The means are right.
TEST(hydrostatic, a_column_at_default_tolerances) {
  const Rest rest = settle(1e-3);
  const std::string column = "hydrostatic column 0.5 m, d = H/20, tolerance 1e-3: ", theory = "p = ρ g (H − z)";
  report({column + "rms of the layers' mean p over ρgH", theory, rest.layers, 0.02, "1", 0.03});
  report({column + "mean compression", "0", rest.compression, 1e-3});
  report({column + "mean load on the box over the weight, − 1", "weight", rest.load, 0.002, "1", 0.02});
  report({column + "largest kinetic energy of the third 0.75 s over the second", "decays", rest.growth, 1, "1", 1.2});
}

// At h = 2 d all three have the same neighbours, and a step takes the same time but for the iterations, which the runs
// print.
TEST(hydrostatic, the_three_kernels) {
  for (const std::string kernel : {"cubic", "wendland", "poly6"}) {
    const Rest rest = settle(1e-4, 10, kernel);
    report({"hydrostatic column, d = H/10, h = 2 d, tolerance 1e-4, " + kernel + ": rms of the particles' mean p over ρgH",
            "p = ρ g (H − z)", rest.pressure, 0.02, "1", 0.2});
  }
}

}  // namespace drench::test
