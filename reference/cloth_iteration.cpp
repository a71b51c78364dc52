// The iterations of the cloth's step, by Projective Dynamics and by XPBD (src/stages/cloth.hpp).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cloth_problem.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int plain_iterations = 10;  // without acceleration, at a solve's start
constexpr int plain_later = 2;        // after its target has moved, where there are no solids
constexpr int patient = 9;            // checks after which the residual must have fallen

double mean_length(const ClothMesh& mesh) {
  double sum = 0;
  for (const double length : mesh.edge_length) sum += length;
  return mesh.edge_length.empty() ? 0 : sum / static_cast<double>(mesh.edge_length.size());
}

}  // namespace

ClothIteration::ClothIteration(const ClothProblem& problem, const Vectors& first)
    : problem_(problem),
      solver_(problem.model().scene.cloth_solver),
      x_(first),
      previous_(first),
      smallest_(std::numeric_limits<double>::infinity()),
      plain_(plain_iterations) {
  // A bound for the spectral radius of the Jacobi iteration's linear part.
  std::vector<double> slowness;  // Δt² D/m
  for (std::size_t n = 0; n < first.size(); ++n) {
    const bool free = problem.is_free(static_cast<Index>(n));
    slowness.push_back(free ? problem.dt * problem.dt * problem.diagonal[n] / problem.mass[n] : 1);
    rho_ = std::max(rho_, 1 - 1 / slowness[n]);
  }
  const int accelerated = solver_.max_iterations - plain_iterations;
  const double reachable = accelerated > 0 ? 1 / std::cosh(std::acosh(3.0) / accelerated) : 0.0;
  if (solver_.method == ClothMethod::xpbd) patience_ = rho_ > reachable ? 1 : patient;
  rho_ = std::min(rho_, reachable);
  if (solver_.method == ClothMethod::pd) return;
  const ClothMesh& mesh = problem.model().mesh;
  for (Index e = 0; e < problem.springs(); ++e) {
    const std::size_t own = mesh.edge.size(), at = static_cast<std::size_t>(e);
    const std::array<Index, 2>& ends = at < own ? mesh.edge[at] : mesh.stitch[at - own];
    spring_.push_back(problem.spring_force(e, first));
    spring_rate_.push_back(2 / (slowness[ends[0]] + slowness[ends[1]]));
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    hinge_.push_back(problem.hinge_force(static_cast<Index>(h), first));
    double weights = 0, weighted = 0;
    for (int a = 0; a < 4; ++a) {
      weights += std::abs(mesh.hinge_weight[h][a]);
      weighted += std::abs(mesh.hinge_weight[h][a]) * slowness[mesh.hinge[h][a]];
    }
    hinge_rate_.push_back(weights > 0 ? weights / weighted : 1);
  }
  for (Index t = 0; problem.model().has_triangle_stress() && t < mesh.triangles(); ++t) {
    triangle_.push_back(problem.triangle_stress(t, first));
    const Eigen::Matrix<double, 3, 2> weights = corner_gradients(rest_frame(mesh, t)).cwiseAbs();
    Eigen::Vector3d q;
    for (int c = 0; c < 3; ++c) q[c] = slowness[mesh.triangle[t][c]];
    triangle_rate_.push_back(weights.colwise().sum().transpose().cwiseQuotient(weights.transpose() * q));
    // A membrane joins the columns: they move alike.
    if (problem.model().has_membrane() && mesh.membrane[t].warp > 0)
      triangle_rate_.back().setConstant(triangle_rate_.back().minCoeff());
  }
  last_triangle_.assign(triangle_.size(), Stress::Zero());
  last_spring_.assign(spring_.size(), Vector3d::Zero());
  last_hinge_.assign(hinge_.size(), Vector3d::Zero());
}

void ClothIteration::start() {
  gather();
  const double own = residual();
  spring_.swap(last_spring_);
  hinge_.swap(last_hinge_);
  triangle_.swap(last_triangle_);
  gather();
  if (10 * residual() < own) return;  // they push the cloth about: none
  spring_.swap(last_spring_);
  hinge_.swap(last_hinge_);
  triangle_.swap(last_triangle_);
  gather();
}

void ClothIteration::advance(int count) {
  if (solver_.method == ClothMethod::xpbd) {
    previous_ = x_;  // where contact planes touch the bodies from here on
    if (iterations_ == 0) start();
  }
  for (int k = 0; k < count; ++k) {
    ++iterations_;
    ++since_restart_;
    if (since_restart_ <= plain_)
      omega_ = 1;
    else if (since_restart_ == plain_ + 1)
      omega_ = 2 / (2 - rho_ * rho_);
    else
      omega_ = 4 / (4 - rho_ * rho_ * omega_);
    if (solver_.method == ClothMethod::pd)
      iterate_positions();
    else
      iterate_multipliers();
  }
}

void ClothIteration::move_on() {
  if (iterations_ == 0) return;
  since_restart_ = 0;
  plain_ = problem_.bodies.empty() ? plain_later : plain_iterations;
  if (patience_ > 0 && last_residual_ > 1) patience_ = 1;
  smallest_ = std::numeric_limits<double>::infinity();
  checks_.clear();
}

void ClothIteration::iterate_positions() {
  const Vectors r = problem_.residual(x_);
  Vectors next = x_;
  for (Index n = 0; n < problem_.model().mesh.nodes(); ++n) {
    if (!problem_.is_free(n)) continue;
    Vector3d step = r[n] / problem_.diagonal[n];
    const NodeContact touched = problem_.contact(n, x_[n], step, problem_.diagonal[n]);
    next[n] += step;
    if (touched.press > 0)
      next[n] = problem_.with_friction(touched, n, x_[n], next[n], problem_.friction(n) * touched.press);
  }
  for (std::size_t n = 0; n < next.size(); ++n) next[n] = omega_ * (next[n] - previous_[n]) + previous_[n];
  problem_.project(next);
  previous_ = x_;
  x_ = next;
}

void ClothIteration::iterate_multipliers() {
  const auto relax = [this](Vectors& now, Vectors& before, std::size_t k, const Vector3d& law, double rate) {
    const Vector3d next = now[k] + rate * (law - now[k]);
    before[k] = omega_ * (next - before[k]) + before[k];
  };
  for (std::size_t e = 0; e < spring_.size(); ++e) {
    relax(spring_, last_spring_, e, problem_.spring_force(static_cast<Index>(e), x_), spring_rate_[e]);
  }
  for (std::size_t h = 0; h < hinge_.size(); ++h) {
    relax(hinge_, last_hinge_, h, problem_.hinge_force(static_cast<Index>(h), x_), hinge_rate_[h]);
  }
  for (std::size_t t = 0; t < triangle_.size(); ++t) {
    const Stress law = problem_.triangle_stress(static_cast<Index>(t), x_);
    const Stress next = triangle_[t] + (law - triangle_[t]) * triangle_rate_[t].asDiagonal();
    last_triangle_[t] = omega_ * (next - last_triangle_[t]) + last_triangle_[t];
  }
  spring_.swap(last_spring_);
  hinge_.swap(last_hinge_);
  triangle_.swap(last_triangle_);
  gather();
}

void ClothIteration::gather() {
  const Vectors force = problem_.gathered(spring_, hinge_, triangle_);
  for (std::size_t n = 0; n < x_.size(); ++n) {
    if (!problem_.is_free(static_cast<Index>(n))) continue;
    const Vector3d free = problem_.target[n] + problem_.dt * problem_.dt / problem_.mass[n] * force[n];
    const auto node = static_cast<Index>(n);
    Vector3d step = free - previous_[n];
    const NodeContact touched =
        problem_.contact(node, previous_[n], step, problem_.mass[n] / (problem_.dt * problem_.dt));
    if (touched.press > 0)
      x_[n] = problem_.with_friction(touched, node, previous_[n], previous_[n] + step,
                                     problem_.friction(node) * touched.press);
    else
      x_[n] = problem_.before_planes(node, previous_[n], free);
  }
  problem_.project(x_);
}

double ClothIteration::residual() const {
  const ClothProblem& p = problem_;
  const Vectors r = p.residual(x_);
  const double rounding =
      0.5 * std::numeric_limits<double>::epsilon() * mean_length(p.model().mesh);  // m: what the sums cannot tell apart
  double left = 0, goal = 0;
  for (Index n = 0; n < p.model().mesh.nodes(); ++n) {
    if (!p.is_free(n)) continue;
    left += p.unbalanced(n, x_[n], r[n]).norm();
    goal +=
        solver_.tolerance * p.mass[n] / (p.dt * p.dt) * (p.target[n] - p.start[n]).norm() + rounding * p.diagonal[n];
  }
  return left == 0 ? 0 : left / goal;
}

double ClothIteration::check() {
  const double residual = this->residual();
  const std::size_t checks = checks_.size(), patience = patience_;
  if (patience > 0 && checks > 0 && checks % patience == 0 && residual > checks_[checks - patience])
    slow_down(plain_later);
  if (residual > 10 * smallest_) slow_down(plain_iterations);
  smallest_ = std::min(smallest_, residual);
  checks_.push_back(residual);
  return last_residual_ = residual;
}

void ClothIteration::slow_down(int before_weights) {
  rho_ = std::max(0.0, 1 - 2 * (1 - rho_));
  since_restart_ = 0;
  plain_ = before_weights;
}

void ClothIteration::line_search() {
  const ClothProblem& p = problem_;
  Vectors still = x_;
  for (std::size_t n = 0; n < still.size(); ++n) {
    if (p.is_free(static_cast<Index>(n))) still[n] = p.start[n];
  }
  const Vectors before = p.residual(still), after = p.residual(x_);
  for (const ClothMaterial& cloth : p.model().cloths) {
    double a = 0, b = 0;  // J
    for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
      if (!p.is_free(n)) continue;
      a += before[n].dot(x_[n] - p.start[n]);
      b += p.unbalanced(n, x_[n], after[n]).dot(x_[n] - p.start[n]);
    }
    if (b >= 0) continue;
    const double share = a > 0 ? a / (a - b) : 0;
    for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
      if (p.is_free(n)) x_[n] = p.start[n] + share * (x_[n] - p.start[n]);
    }
  }
}

}  // namespace drench::reference
