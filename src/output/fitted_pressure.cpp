#include "output/fitted_pressure.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "output/grid_tools.hpp"
#include "setup/point_grid.hpp"

namespace drench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double least_variance = 0.02;  // d²: the fit has no slope where neighbours spread less than that

/// Weighted moments of the particles within h around one of them; positions are relative to it, m.
struct Moments {
  double weight = 0, pressure = 0;
  Vector3d place = Vector3d::Zero(), product = Vector3d::Zero();
  Matrix3d square = Matrix3d::Zero();

  void add(double w, const Vector3d& r, double p) {
    weight += w;
    pressure += w * p;
    place += w * r;
    product += w * p * r;
    square += w * r * r.transpose();
  }
  /// The fit's value at the particle.
  double value(double spacing) const {
    const double mean = pressure / weight;
    const Vector3d center = place / weight, slope_of = product / weight - mean * center;
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(square / weight - center * center.transpose());
    double value = mean;
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = solver.eigenvectors().col(k);
      const double variance = solver.eigenvalues()[k];
      if (variance > least_variance * spacing * spacing) value -= axis.dot(center) * axis.dot(slope_of) / variance;
    }
    return value;
  }
};

}  // namespace

std::vector<double> fitted_pressure(const Model& model, const HostState& state, int threads) {
  const double h = model.support;
  const std::size_t count = state.fluid_position.size();
  std::vector<double> own(count), fitted(count);
  PointGrid grid(h);
  std::vector<std::size_t> particle;  // of the grid's points; those that are not finite have no cell
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& x = state.fluid_position[i];
    own[i] = particle_pressure(model, state, i);
    fitted[i] = own[i];
    if (!std::isfinite(x[0] + x[1] + x[2] + own[i])) continue;
    grid.add(x);
    particle.push_back(i);
  }
  for_ranges(particle.size(), threads, [&](std::size_t g) {
    const Vec3& x = grid.points()[g];
    Moments moments;
    grid.for_box({x[0] - h, x[1] - h, x[2] - h}, {x[0] + h, x[1] + h, x[2] + h}, [&](Index j) {
      const std::size_t near = static_cast<std::size_t>(j);
      const Vector3d r = to_eigen(grid.points()[near]) - to_eigen(x);
      const double t = 1 - r.squaredNorm() / (h * h);
      if (t > 0) moments.add(t * t * static_cast<double>(state.fluid_mass[particle[near]]), r, own[particle[near]]);
    });
    fitted[particle[g]] = moments.value(model.spacing);
  });
  return fitted;
}

}  // namespace drench
