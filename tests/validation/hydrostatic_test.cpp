// A column of water in a closed box comes to rest: pressure, compression, energy and the load on the box.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/eigen_vec.hpp"
#include "output/fitted_pressure.hpp"
#include "setup/point_grid.hpp"
#include "setup/smoothing_kernel.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double gravity = 9.81, height = 0.5;  // m/s², m

/// A column of water, `wide` spacings in both directions, in a closed box.
struct Column {
  double tolerance = 1e-5;
  int across = 20;  // layers
  int wide = 20;
  std::string kernel = "cubic";
  double support = 2;                       // h/d
  double step = 0.004;                      // s
  std::optional<double> source_error = {};  // η
  double period = 0.75;                     // s, of three

  double spacing() const { return height / across; }
  double width() const { return wide * spacing(); }
  std::string scene() const {
    return fmt::format(R"(drench: 1
time: {{step: {0}, end: 30}}
fluid:
  spacing: {1}
  kernel: {2}
  support: {7}
  wall_pressure: extrapolated
  viscosity: 0.003
  solver: {{density_error: {3}, divergence_error: {3}{4}}}
  sources: [{{block: {{min: [0, 0, 0], max: [{5}, {6}, {5}]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [{5}, 0.7, {5}], inside: true}}}}]
)",
                       step, spacing(), kernel, tolerance,
                       source_error ? fmt::format(", source_error: {}", *source_error) : "", width(), height, support);
  }
};

using Eigen::Vector3d;

/// Sums over the samples around a particle at a wall (docs/theory/walls_and_sheets.md), for Σ m_i of what the box does
/// to it.
struct AtWall {
  double drag = 0;                       // of viscosity, m/s² upward, negative
  Vector3d gradient = Vector3d::Zero();  // s, 1/m
  double lengths = 0;                    // S, 1/m
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();

  /// L of Eq. 7c.
  Eigen::Matrix3d gain() const {
    const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d along = one - gradient * gradient.transpose() / gradient.squaredNorm();
    const double weight = std::min(1.0, gradient.squaredNorm() / (0.1 * lengths * lengths));
    const Eigen::Matrix3d m = weight * along * square * along;
    return one + m + m * m + m * m * m + m * m * m * m;
  }
};

/// Load on the box (N, downward) in a step: the reactions of src/stages/divergence.hpp (both solves) and forces.hpp
/// over all samples, from the pressures, positions and velocities at its beginning. The floor's samples alone do not
/// carry the weight: the walls' lowest ones and those in the corner push the lowest layer too.
double load_on_box(const Model& model, double width, const HostState& start, const HostState& end) {
  const double h = model.support, viscous = 80.0 / 3 * model.scene.fluid.viscosity / (h * h);  // χ of the cubic spline
  const KernelKind kernel = model.scene.fluid.kernel;
  const double held = kernel == KernelKind::cubic ? h / 3 : kernel == KernelKind::wendland ? h / 4 : 0;
  PointGrid samples(h), liquid(h);
  for (const Vec3& x : start.boundary_position) samples.add(x);
  for (const Vec3& x : start.fluid_position) liquid.add(x);
  const auto kappa = [&](std::size_t i) { return end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i]; };
  const auto for_near = [&](const PointGrid& grid, const Vec3& x, auto&& f) {
    grid.for_box({x[0] - h, x[1] - h, x[2] - h}, {x[0] + h, x[1] + h, x[2] + h}, [&](Index k) {
      const Vector3d r = to_eigen(x) - to_eigen(grid.points()[static_cast<std::size_t>(k)]);
      if (r.norm() < h) f(static_cast<std::size_t>(k), r);
    });
  };
  double load = 0;
  for (std::size_t i = 0; i < start.fluid_position.size(); ++i) {
    const Vec3& x = start.fluid_position[i];
    if (x[0] > h && x[0] < width - h && x[2] > h && x[2] < width - h && x[1] > h) continue;
    const double mass = kilograms(model, start.fluid_mass[i]);
    AtWall wall;
    for_near(samples, x, [&](std::size_t b, const Vector3d& r) {
      const double slope = start.boundary_volume[b] * kernel_derivative(kernel, r.norm(), h);
      wall.drag += viscous / end.fluid_density_ratio[i] * to_eigen(start.fluid_velocity[i]).dot(r) * 2 * slope * r.y();
      wall.gradient += 2 * slope * r;
      wall.lengths -= 2 * slope * r.norm();
      wall.square -= slope * r * r.transpose();
    });
    if (wall.lengths == 0) continue;
    load += mass * (wall.drag - kappa(i) * wall.gradient.y());
    Vector3d a = -kappa(i) * wall.gradient;
    for_near(liquid, x, [&](std::size_t j, const Vector3d& r) {
      if (j == i) return;
      const double volume = kilograms(model, start.fluid_mass[j]) / model.rest_density;
      const double far = std::max(r.norm(), held);
      a -= volume * (kappa(i) + kappa(j)) * kernel_derivative(kernel, far, h) * far / r.norm() * r;
    });
    load += mass * (wall.gain() * a - a).y();
  }
  return load;
}

struct Rest {
  // rms of the time mean's error over ρ g H: of particles' fitted p, of means of κ over layers
  double pressure = 0, layers = 0;
  double raw = 0;          // of particles' κ, which nobody is shown
  double swing = 0;        // rms of the fitted p in one step, its mean
  double compression = 0;  // mean of max(0, δ − 1), its time mean
  double load = 0;         // |mean load on the box / weight − 1|
  double iterations = 0, most_iterations = 0;
  double growth = 0;  // largest kinetic energy of the last period over that of the one before
  double unrest = 0;  // largest kinetic energy of the last period over m g d
};

/// Mean of the liquid's heights, doubled: walls keep the liquid a little off, so that it stands higher than it was cut.
double surface_of(const std::vector<double>& height_of) {
  double sum = 0;
  for (const double y : height_of) sum += y;
  return 2 * sum / static_cast<double>(height_of.size());
}

/// Each particle's error of p/ρ (m²/s²) at its height (m), over g H.
std::vector<double> errors_of(const std::vector<double>& kappa, const std::vector<double>& height_of) {
  const double surface = surface_of(height_of);
  std::vector<double> error;
  for (std::size_t i = 0; i < kappa.size(); ++i)
    error.push_back(kappa[i] / (gravity * surface) - (1 - height_of[i] / surface));
  return error;
}

double rms(const std::vector<double>& error) {
  double sum = 0;
  for (const double e : error) sum += e * e;
  return std::sqrt(sum / static_cast<double>(error.size()));
}

/// The same of means over layers as thick as a spacing, with each particle's weight.
double rms_of_layers(const std::vector<double>& error, const std::vector<double>& height_of, double spacing) {
  std::map<int, std::array<double, 2>> layer;  // Σ error, count of particles
  for (std::size_t i = 0; i < error.size(); ++i) {
    auto& l = layer[static_cast<int>(height_of[i] / spacing)];
    l[0] += error[i];
    l[1] += 1;
  }
  double sum = 0;
  for (const auto& [_, l] : layer) sum += l[0] * l[0] / l[1];
  return std::sqrt(sum / static_cast<double>(error.size()));
}

/// Three periods of a column; means over the last one.
Rest settle(const Column& column) {
  SceneRun run(column.scene());
  const std::size_t n = run.initial().fluid_position.size();
  const double weight = gravity * static_cast<double>(n) * run.model().particle_mass, rho = run.model().rest_density;
  const int period = static_cast<int>(std::lround(column.period / column.step));
  std::vector<double> kappa(n, 0), fitted(n, 0), height_of(n, 0);
  Rest rest;
  double energy[3] = {0, 0, 0};
  for (int k = 0; k < 2 * period; ++k) {
    double& largest = energy[k / period];
    largest = std::max(largest, run.step().kinetic_energy);
  }
  HostState start = run.state();
  double clamped = 0, divergence_iterations = 0;
  for (int k = 0; k < period; ++k) {
    const StepReport r = run.step();
    energy[2] = std::max(energy[2], r.kinetic_energy);
    clamped += static_cast<double>(r.clamped) / period;
    rest.iterations += double(r.density_iterations) / period;
    divergence_iterations += double(r.divergence_iterations) / period;
    rest.most_iterations = std::max<double>(rest.most_iterations, r.density_iterations);
    const HostState end = run.state();
    rest.load += load_on_box(run.model(), column.width(), start, end) / weight / period;
    HostState felt = end;  // the pressure of a step belongs to the positions at its start
    felt.fluid_position = start.fluid_position;
    std::vector<double> now = fitted_pressure(run.model(), felt), at;
    for (std::size_t i = 0; i < n; ++i) {
      now[i] /= rho;
      at.push_back(start.fluid_position[i][1]);
      kappa[i] += (end.fluid_kappa_density[i] + end.fluid_kappa_divergence[i]) / period;
      fitted[i] += now[i] / period;
      height_of[i] += at[i] / period;
      rest.compression += std::max(0.0, end.fluid_density_ratio[i] - 1) / static_cast<double>(n) / period;
    }
    rest.swing += rms(errors_of(now, at)) / period;
    start = end;
  }
  rest.raw = rms(errors_of(kappa, height_of));
  rest.pressure = rms(errors_of(fitted, height_of));
  rest.layers = rms_of_layers(errors_of(kappa, height_of), height_of, column.spacing());
  rest.load = std::fabs(rest.load - 1);
  rest.growth = energy[2] / energy[1];
  rest.unrest = energy[2] / (weight * column.spacing());
  std::printf(
      "%s, extrapolated walls, d = H/%d, %d d wide, %g ms, tolerance %g, source_error %g: surface %.4f m; largest "
      "energies of "
      "the "
      "periods %.3e %.3e %.3e J; %.2f particles a step put back by the box; density iterations %.1f, at most %g; "
      "divergence %.1f; rms of particles' mean kappa %.4f, of their mean fitted p %.4f, of layers %.4f; of the fitted "
      "p in a "
      "step %.4f; load %.2e\n",
      column.kernel.c_str(), column.across, column.wide, 1e3 * column.step, column.tolerance,
      column.source_error.value_or(0), surface_of(height_of), energy[0], energy[1], energy[2], clamped, rest.iterations,
      rest.most_iterations, divergence_iterations, rest.raw, rest.pressure, rest.layers, rest.swing, rest.load);
  return rest;
}

}  // namespace

std::string name(const Column& column, const std::string& of) {
  return fmt::format("hydrostatic column 0.5 m, d = H/{}, {} d wide, extrapolated walls, tolerance {}: {}",
                     column.across, column.wide, column.tolerance, of);
}
constexpr const char* theory = "p = ρ g (H − z)";
constexpr const char* of_particles = "rms of the particles' mean fitted p over ρgH";
constexpr const char* of_layers = "rms of the layers' mean p over ρgH";
constexpr const char* of_unrest = "largest kinetic energy from 1.5 to 2.25 s over m g d";
constexpr double target_of_particles = 0.025, target_of_layers = 0.02, target_of_unrest = 0.01;

TEST(hydrostatic, a_column_comes_to_rest) {
  const Column column, wide_grid{.across = 10, .wide = 10};
  const Rest rest = settle(column), coarse = settle(wide_grid);
  report({name(column, of_particles), theory, rest.pressure, target_of_particles});
  report({name(column, of_layers), theory, rest.layers, target_of_layers});
  report({name(wide_grid, of_layers), theory, coarse.layers, target_of_layers});
  report({name(column, "mean compression"), "0", rest.compression, 1e-3});
  report({name(column, "mean load on the box over the weight, − 1"), "weight", rest.load, 0.002});
  report({name(column, of_unrest), "at rest", rest.unrest, target_of_unrest});
  report({name(column, "most density iterations"), "max_iterations 100", rest.most_iterations, 99});
  std::printf("order of the layers' error in d: %.2f, of the particles' %.2f\n", std::log2(coarse.layers / rest.layers),
              std::log2(coarse.pressure / rest.pressure));
}

TEST(hydrostatic, a_narrow_column_comes_to_rest) {
  for (const double step : {0.004, 0.002, 0.001}) {
    const Column column{.wide = 8, .step = step};
    const Rest rest = settle(column);
    const std::string at = fmt::format(" at {:g} ms", 1e3 * step);
    report({name(column, of_particles + at), theory, rest.pressure, target_of_particles});
    report({name(column, of_layers + at), theory, rest.layers, target_of_layers});
  }
}

// The default tolerance, a mean compression of 1e-3, is more than a step's gravity does to an unsupported column
// (g Δt²/H = 3e-4). The means over many steps are right; source_error makes each step's right. Until then the column
// never comes to rest, and roundings decide how it moves: of 15 columns whose viscosities differ by 1e-6 to 1.4e-5 (27
// November 2026, float) the load is 0.00007 to 0.0068 off, and the energies have ratios of 0.87 to 2.1.
TEST(hydrostatic, a_column_at_default_tolerances) {
  for (const bool improved : {false, true}) {
    Column column{.tolerance = 1e-3};
    if (improved) column.source_error = 0.1;
    const Rest rest = settle(column);
    const auto row = [&](const std::string& of) { return name(column, (improved ? "source_error 0.1: " : "") + of); };
    report({row(of_layers), theory, rest.layers, target_of_layers});
    report({row("mean compression"), "0", rest.compression, 1e-3});
    const std::string of_load = row("mean load on the box over the weight, − 1");
    if (improved) {
      report({of_load, "weight", rest.load, 0.002});
      report({row(of_unrest), "at rest", rest.unrest, target_of_unrest});
      continue;
    }
    constexpr const char* reason = "A column at this tolerance does not come to rest.";
    report({of_load, "weight", rest.load, 0.002, "1", {0.0074, 0.0074, 0.0068}, reason});
    report({row("largest kinetic energy of the third 0.75 s over the second"),
            "decays",
            rest.growth,
            1,
            "1",
            {2.3, 2.3, 2.11},
            reason});
  }
}

// A part of a step's own compression is left: the error of a step's pressure then does not depend on the step's length.
TEST(hydrostatic, a_shorter_step_is_no_worse) {
  for (const double step : {0.004, 0.002, 0.001, 0.0005}) {
    const Column column{.tolerance = 1e-3, .wide = 8, .step = step, .source_error = 0.1, .period = 1.5};
    const Rest rest = settle(column);
    report({name(column, fmt::format("source_error 0.1, {:g} ms: rms of the fitted p in a step over ρgH", 1e3 * step)),
            theory, rest.swing, 0.02});
  }
}

// What the last step's pressure is good for: the same column with κ = 0 before every step.
TEST(hydrostatic, the_warm_start_saves_iterations) {
  double iterations[2] = {0, 0};
  for (int cold = 0; cold < 2; ++cold) {
    SceneRun run(R"(drench: 1
time: {step: 0.004, end: 3}
fluid:
  spacing: 0.05
  viscosity: 0.01
  solver: {density_error: 1.0e-5, divergence_error: 1.0e-5}
  sources: [{block: {min: [0, 0, 0], max: [0.5, 1, 0.5]}}]
bodies: [{box: {min: [0, 0, 0], max: [0.5, 1.2, 0.5], inside: true}}]
)");
    constexpr int settling = 100, steps = 100;
    for (int k = 0; k < settling; ++k) run.step();
    for (int k = 0; k < steps; ++k) {
      HostState s = run.state();
      if (cold) {
        std::fill(s.fluid_kappa_density.begin(), s.fluid_kappa_density.end(), 0.0);
        std::fill(s.fluid_kappa_divergence.begin(), s.fluid_kappa_divergence.end(), 0.0);
      }
      run.restart(s);
      const StepReport r = run.step();
      iterations[cold] += double(r.density_iterations + r.divergence_iterations) / steps;
    }
  }
  std::printf("iterations a step: warm %.1f, cold %.1f\n", iterations[0], iterations[1]);
  report({"column of 20 layers at rest, tolerance 1e-5: iterations with the warm start over those without", "fewer",
          iterations[0] / iterations[1], 0.7});
}

// Each kernel with the support that docs/manual/liquids.md recommends. The walls' own error is not the kernel's: they
// extrapolate.
TEST(hydrostatic, the_three_kernels) {
  const std::pair<const char*, double> kernels[] = {{"cubic", 2}, {"wendland", 3}, {"poly6", 2.5}};
  for (const auto& [kernel, support] : kernels) {
    const Column column{.tolerance = 1e-4, .wide = 10, .kernel = kernel, .support = support};
    const Rest rest = settle(column);
    report({name(column, fmt::format("{}, h = {} d: {}", kernel, support, of_particles)), theory, rest.pressure,
            target_of_particles});
  }
}

}  // namespace drench::test
