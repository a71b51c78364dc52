#include "cloth_problem.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int plain_iterations = 10;    // without acceleration
constexpr double tolerance = 1e-3;      // of Σ m |y − x⁰|/Δt²
constexpr double contact_range = 1.01;  // of the thickness

double mean_length(const ClothMesh& mesh) {
  double sum = 0;
  for (const double length : mesh.edge_length) sum += length;
  return mesh.edge_length.empty() ? 0 : sum / static_cast<double>(mesh.edge_length.size());
}

/// Rest shape of a triangle in its own plane, D (m): the deformation is F = [x1 − x0, x2 − x0] D⁻¹, by Eigen's QR.
Eigen::Matrix2d rest_frame(const ClothMesh& mesh, Index t) {
  const auto [a, b, c] = mesh.triangle[t];
  Eigen::Matrix<double, 3, 2> edges;
  edges << vec(mesh.rest_position[b]) - vec(mesh.rest_position[a]),
      vec(mesh.rest_position[c]) - vec(mesh.rest_position[a]);
  return Eigen::Matrix2d(edges.householderQr().matrixQR().topRows<2>().triangularView<Eigen::Upper>());
}

/// Rows: ∇N of the three corners in that plane, 1/m.
Eigen::Matrix<double, 3, 2> corner_gradients(const Eigen::Matrix2d& frame) {
  const Eigen::Matrix2d inverse = frame.inverse();
  Eigen::Matrix<double, 3, 2> rows;
  rows << -inverse.row(0) - inverse.row(1), inverse.row(0), inverse.row(1);
  return rows;
}

}  // namespace

double node_saturation(const ReferenceState& state, Index n) {
  const auto& capacity = state.model.samples.node_capacity;
  if (capacity.empty() || !(capacity[n] > 0)) return 0;
  return std::min(1.0, static_cast<double>(state.s.node_liquid[n]) * state.model.quantum / capacity[n]);
}

Vector3d pin_position(const ReferenceState& state, Index n, double time) {
  const Model& m = state.model;
  const Index motion = m.mesh.pin_motion.empty() ? -1 : m.mesh.pin_motion[n];
  if (motion < 0) return vec(state.s.node_position[n]);
  const PinMotion& p = m.pin_motions[motion];
  const double since = std::min(std::max(time, p.start), p.end) - p.start;
  const Eigen::AngleAxisd turn(p.rate * since, vec(p.axis));
  return vec(p.center) + since * vec(p.velocity) + turn * (vec(m.mesh.rest_position[n]) - vec(p.center));
}

ClothProblem::ClothProblem(const ReferenceState& s, double step) : state(s), dt(step), bodies(placed_bodies(s, step)) {
  const ClothMesh& mesh = model().mesh;
  for (const Vec3& x : state.s.node_position) start.push_back(vec(x));
  target = start;
  for (Index n = 0; n < mesh.nodes(); ++n) {
    mass.push_back(node_mass(state, n));
    diagonal.push_back(mass[n] / (dt * dt));
  }
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    for (const Index n : mesh.edge[e]) diagonal[n] += (1 + material(n).strain_damping / dt) * mesh.edge_stiffness[e];
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    double sum = 0;
    for (const double weight : mesh.hinge_weight[h]) sum += std::abs(weight);
    for (int a = 0; a < 4; ++a) {
      diagonal[mesh.hinge[h][a]] += 0.5 * mesh.hinge_stiffness[h] * std::abs(mesh.hinge_weight[h][a]) * sum;
    }
  }
  if (!model().has_strain_limit()) return;
  for (Index t = 0; t < mesh.triangles(); ++t) {
    const Eigen::Matrix<double, 3, 2> rows = corner_gradients(rest_frame(mesh, t));
    const Eigen::Matrix3d stiffness = mesh.limit_stiffness[t] * rows * rows.transpose();
    for (int c = 0; c < 3; ++c) diagonal[mesh.triangle[t][c]] += 0.5 * stiffness.row(c).cwiseAbs().sum();
  }
}

Vectors ClothProblem::internal_force(const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  Vectors force(x.size(), Vector3d::Zero());
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    const auto [i, j] = mesh.edge[e];
    const Vector3d along = x[i] - x[j];
    const double length = along.norm();
    const Vector3d rest = length > 0 ? Vector3d(mesh.edge_length[e] / length * along) : Vector3d::Zero();
    Vector3d f = mesh.edge_stiffness[e] * (along - rest);
    // Kelvin–Voigt: the rate of stretching along the edge as it lay at the start of the step
    const Vector3d direction = (start[i] - start[j]).normalized();
    const double rate = ((along - (start[i] - start[j])) / dt).dot(direction);
    f += mesh.edge_stiffness[e] * material(i).strain_damping * rate * direction;
    force[i] -= f;
    force[j] += f;
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    Vector3d bend = Vector3d::Zero();
    for (int a = 0; a < 4; ++a) bend += mesh.hinge_weight[h][a] * x[mesh.hinge[h][a]];
    for (int a = 0; a < 4; ++a) {
      force[mesh.hinge[h][a]] -= mesh.hinge_stiffness[h] * mesh.hinge_weight[h][a] * bend;
    }
  }
  for (Index t = 0; model().has_strain_limit() && t < mesh.triangles(); ++t) {
    const double limit = model().cloths[mesh.triangle_cloth[t]].strain_limit;
    const auto [a, b, c] = mesh.triangle[t];
    Eigen::Matrix<double, 3, 2> edges;
    edges << x[b] - x[a], x[c] - x[a];
    const Eigen::Matrix2d frame = rest_frame(mesh, t);
    const Eigen::Matrix<double, 3, 2> deformation = edges * frame.inverse();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(deformation, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::Vector2d clamped = svd.singularValues();
    for (double& sigma : clamped) {
      if (sigma > 0) sigma = std::min(std::max(sigma, 1 - limit), 1 + limit);
    }
    const Eigen::Matrix<double, 3, 2> nearest = svd.matrixU() * clamped.asDiagonal() * svd.matrixV().transpose();
    const Eigen::Matrix3d f =
        -mesh.limit_stiffness[t] * (deformation - nearest) * corner_gradients(frame).transpose();  // a column a corner
    for (int k = 0; k < 3; ++k) force[mesh.triangle[t][k]] += f.col(k);
  }
  return force;
}

Vectors ClothProblem::residual(const Vectors& x) const {
  Vectors r = internal_force(x);
  for (std::size_t n = 0; n < r.size(); ++n) r[n] += mass[n] / (dt * dt) * (target[n] - x[n]);
  return r;
}

void ClothProblem::project(Vectors& x) const {
  for (Index n = 0; n < model().mesh.nodes(); ++n) {
    if (is_free(n)) project_out(bodies, material(n).thickness, x[n]);
  }
}

Contact ClothProblem::contact(Index n, const Vector3d& x) const {
  Contact last{Vector3d::Zero(), Vector3d::Zero()};
  if (!is_free(n)) return last;
  for (const PlacedBody& body : bodies) {
    Vector3d normal;
    const std::optional<double> distance = distance_to(body, x, normal);
    if (distance && *distance < contact_range * material(n).thickness) last = {normal, body.pose.velocity_at(x)};
  }
  return last;
}

ClothIteration::ClothIteration(const ClothProblem& problem, const Vectors& first)
    : problem_(problem), x_(first), previous_(first), smallest_(std::numeric_limits<double>::infinity()) {
  // A bound for the spectral radius of the Jacobi iteration's linear part.
  for (std::size_t n = 0; n < first.size(); ++n) {
    if (!problem.is_free(static_cast<Index>(n))) continue;
    rho_ = std::max(rho_, 1 - problem.mass[n] / (problem.dt * problem.dt * problem.diagonal[n]));
  }
}

void ClothIteration::advance(int count) {
  for (int k = 0; k < count; ++k) {
    ++iterations_;
    ++since_restart_;
    if (since_restart_ <= plain_iterations)
      omega_ = 1;
    else if (since_restart_ == plain_iterations + 1)
      omega_ = 2 / (2 - rho_ * rho_);
    else
      omega_ = 4 / (4 - rho_ * rho_ * omega_);
    const Vectors r = problem_.residual(x_);
    Vectors next = x_;
    for (std::size_t n = 0; n < next.size(); ++n) {
      if (problem_.is_free(static_cast<Index>(n))) next[n] += r[n] / problem_.diagonal[n];
    }
    problem_.project(next);
    for (std::size_t n = 0; n < next.size(); ++n) next[n] = omega_ * (next[n] - previous_[n]) + previous_[n];
    problem_.project(next);
    previous_ = x_;
    x_ = next;
  }
}

double ClothIteration::check() {
  const ClothProblem& p = problem_;
  const Vectors r = p.residual(x_);
  const double rounding =
      0.5 * std::numeric_limits<double>::epsilon() * mean_length(p.model().mesh);  // m: what the sums cannot tell apart
  double left = 0, goal = 0;
  for (Index n = 0; n < p.model().mesh.nodes(); ++n) {
    if (!p.is_free(n)) continue;
    const Vector3d normal = p.contact(n, x_[n]).normal;
    left += (r[n] - normal * std::min(0.0, r[n].dot(normal))).norm();
    goal += tolerance * p.mass[n] / (p.dt * p.dt) * (p.target[n] - p.start[n]).norm() + rounding * p.diagonal[n];
  }
  const double residual = left > 0 ? left / goal : 0;
  if (residual > 10 * smallest_) {
    rho_ = std::max(0.0, 1 - 2 * (1 - rho_));
    since_restart_ = 0;
  }
  smallest_ = std::min(smallest_, residual);
  return residual;
}

}  // namespace drench::reference
