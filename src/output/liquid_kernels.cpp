#include "output/liquid_kernels.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "setup/point_grid.hpp"

namespace drench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double ball_radius = 2;                      // d_j
constexpr double ellipsoid_radius = 2.4;               // d_j, of the ball with the ellipsoid's volume
constexpr double neighborhood = 3;                     // d
constexpr double ratio = 4;                            // k_r: of the largest variance to the least
constexpr double smoothing = 0.9;                      // λ
constexpr double few[] = {35, 15}, many[] = {50, 25};  // N_ε, thick and flat: balls below, ellipsoids above
constexpr double thick = 0.2, flat = 0.05;             // 1; the least variance over the largest
constexpr double deep_count = 85, deep = 0.1;          // of 113 neighbors; d: nothing of the surface is near

/// The surroundings of a particle, and the ellipsoid that they make.
struct Neighborhood {
  Vector3d shift = Vector3d::Zero();  // m, to the weighted mean of its neighbors
  Matrix3d axes = Matrix3d::Identity();
  Vector3d stretch{1, 1, 1};  // 1, of each axis; their product is 1
  double shaped = 0;          // 1; 0: a ball at the particle's place
};

/// A sheet has few neighbors, and so has a small drop, which stays a sum of balls: it would lose volume.
double shaped_by(double count, double flatness) {
  const double f = std::clamp((thick - flatness) / (thick - flat), 0.0, 1.0);
  const double least = std::lerp(few[0], few[1], f), enough = std::lerp(many[0], many[1], f);
  return std::clamp((count - least) / (enough - least), 0.0, 1.0);
}

class Neighborhoods {
 public:
  Neighborhoods(const std::vector<SurfaceParticle>& particles, double spacing, int threads)
      : particles_(particles), d_(spacing), radius_(neighborhood * spacing), grid_(radius_), all_(particles.size()) {
    for (const SurfaceParticle& p : particles) grid_.add(p.x);
    for_ranges(all_.size(), threads, [this](std::size_t i) { all_[i] = around(i); });
  }

  const Neighborhood& operator[](std::size_t i) const { return all_[i]; }

  /// Yu and Turk's shift along the shortest axis, less its average around: a flat surface stays where it is, as does
  /// the rim of a sheet, m.
  Vector3d shift(std::size_t i) const {
    const Neighborhood& n = all_[i];
    if (n.shaped == 0) return Vector3d::Zero();
    Vector3d inverse = n.stretch.maxCoeff() / radius_ * n.stretch.cwiseInverse();
    inverse[0] = 1 / (1.25 * d_);  // little of the next layer, or of a sheet's other side
    const Matrix3d layer = n.axes * inverse.asDiagonal();
    double sum = 0;
    Vector3d average = Vector3d::Zero();
    for_near(i, [&](std::size_t j, const Vector3d& r, double) {
      const double t = 1 - (layer.transpose() * r).squaredNorm();
      if (t <= 0) return;
      sum += particles_[j].full * t * t;
      average += particles_[j].full * t * t * all_[j].shift;
    });
    const Vector3d normal = n.axes.col(0);  // of the least variance
    return n.shaped * smoothing * normal.dot(n.shift - average / sum) * normal;
  }

 private:
  /// Calls f(j, x_j − x_i, |x_j − x_i|²) for all neighbors and the particle itself.
  template <class F>
  void for_near(std::size_t i, F&& f) const {
    const Vec3& x = particles_[i].x;
    const double r = radius_;
    grid_.for_box({x[0] - r, x[1] - r, x[2] - r}, {x[0] + r, x[1] + r, x[2] + r}, [&](Index j) {
      const Vec3& y = grid_.points()[static_cast<std::size_t>(j)];
      const Vector3d way{y[0] - x[0], y[1] - x[1], y[2] - x[2]};
      if (const double square = way.squaredNorm(); square < r * r) f(static_cast<std::size_t>(j), way, square);
    });
  }

  Neighborhood around(std::size_t i) const {
    double sum = 0, count = 0;
    Vector3d first = Vector3d::Zero();
    Matrix3d second = Matrix3d::Zero();
    for_near(i, [&](std::size_t j, const Vector3d& r, double square) {
      const double q = std::sqrt(square) / radius_, weight = particles_[j].full * (1 - q * q * q);
      sum += weight;
      count += particles_[j].full;
      first += weight * r;
      second += weight * r * r.transpose();
    });
    Neighborhood n;
    if (count <= few[1]) return n;
    n.shift = first / sum;
    if (count > deep_count && n.shift.squaredNorm() < deep * deep * d_ * d_) return n;
    const Matrix3d covariance = second / sum - n.shift * n.shift.transpose();
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(covariance);
    n.axes = solver.eigenvectors();
    n.shaped = shaped_by(count, solver.eigenvalues()[0] / solver.eigenvalues()[2]);
    const Vector3d variance = solver.eigenvalues().cwiseMax(solver.eigenvalues()[2] / ratio);
    n.stretch = (variance / std::cbrt(variance.prod())).array().pow(0.5 * n.shaped);
    return n;
  }

  const std::vector<SurfaceParticle>& particles_;
  double d_, radius_;  // m
  PointGrid grid_;
  std::vector<Neighborhood> all_;
};

/// The c in a kernel's middle, by which the ball where it is above ½ has 0.62 d_j; h in d_j.
double enough_of(double h) {
  const double t = 1 - 0.62 * 0.62 / (h * h);
  return 0.5 / (t * t * t);
}

/// V_j · 315/(64 π h³), h the radius of the ball with the kernel's volume.
double share_of(const SurfaceParticle& p, double spacing, double h) {
  return p.full * spacing * spacing * spacing * 315 / (64 * std::numbers::pi * h * h * h);
}

Blob round_kernel(const SurfaceParticle& p, double spacing) {
  const double h = ball_radius * p.size, square = 1 / (h * h);
  return {
      p.x,       share_of(p, spacing, h), 0, enough_of(ball_radius), {square, square, square, 0, 0, 0}, {h, h, h}, true,
      p.particle};
}

Blob ellipsoid(const SurfaceParticle& p, double spacing, const Neighborhood& n, const Vector3d& shift) {
  const double radius = ball_radius + n.shaped * (ellipsoid_radius - ball_radius), h = radius * p.size;
  const Vector3d square = (h * n.stretch).array().square();
  const Matrix3d m = n.axes * square.cwiseInverse().asDiagonal() * n.axes.transpose();
  const Matrix3d inverse = n.axes * square.asDiagonal() * n.axes.transpose();
  Blob blob{to_vec3(to_eigen(p.x) + shift), share_of(p, spacing, h), 0, enough_of(radius), {}, {}, false, p.particle};
  blob.metric = {m(0, 0), m(1, 1), m(2, 2), m(1, 2), m(0, 2), m(0, 1)};
  blob.reach = to_vec3(inverse.diagonal().cwiseSqrt());
  return blob;
}

}  // namespace

std::vector<Blob> round_kernels(const std::vector<SurfaceParticle>& particles, double spacing) {
  std::vector<Blob> blobs;
  blobs.reserve(particles.size());
  for (const SurfaceParticle& p : particles) blobs.push_back(round_kernel(p, spacing));
  return blobs;
}

std::vector<Blob> anisotropic_kernels(const std::vector<SurfaceParticle>& particles, double spacing, int threads) {
  const Neighborhoods near(particles, spacing, threads);
  std::vector<Blob> blobs(particles.size());
  for_ranges(blobs.size(), threads, [&](std::size_t i) {
    blobs[i] = near[i].shaped == 0 ? round_kernel(particles[i], spacing)
                                   : ellipsoid(particles[i], spacing, near[i], near.shift(i));
  });
  return blobs;
}

}  // namespace drench
