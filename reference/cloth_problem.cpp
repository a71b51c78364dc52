#include "cloth_problem.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int plain_iterations = 10;    // without acceleration, at a solve's start
constexpr int plain_later = 2;          // after its target has moved, where there are no solids
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
  Eigen::Matrix2d r = edges.householderQr().matrixQR().topRows<2>().triangularView<Eigen::Upper>();
  for (int k = 0; k < 2; ++k)
    if (r(k, k) < 0) r.row(k) *= -1;  // the first axis along the first edge, the second towards the third corner
  return r;
}

/// Rows: ∇N of the three corners in that plane, 1/m.
Eigen::Matrix<double, 3, 2> corner_gradients(const Eigen::Matrix2d& frame) {
  const Eigen::Matrix2d inverse = frame.inverse();
  Eigen::Matrix<double, 3, 2> rows;
  rows << -inverse.row(0) - inverse.row(1), inverse.row(0), inverse.row(1);
  return rows;
}

/// −Σ_m B_nm x_m = Σ_m B_nm (x_n − x_m) of plates, N.
void add_plates(const ClothMesh& mesh, const Vectors& x, Vectors& force) {
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k) {
    const auto [n, m] = mesh.plate_pair[k];
    const Vector3d pull = mesh.plate_weight[k] * (x[n] - x[m]);
    force[n] += pull;
    force[m] -= pull;
  }
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
  const double now = std::min(std::max(time, p.start), p.end);
  const Eigen::AngleAxisd turn(p.rate.integral(p.start, now), vec(p.axis));
  const Eigen::Quaterniond before(p.rotated[0], p.rotated[1], p.rotated[2], p.rotated[3]);
  return vec(p.center) + vec(p.offset) + vec(p.velocity.integral(p.start, now)) + vec(p.path.at(now)) +
         turn * (before * (vec(m.mesh.rest_position[n]) - vec(p.center)));
}

ClothProblem::ClothProblem(const ReferenceState& s, const StepInfo& info)
    : state(s), dt(info.dt), bodies(placed_bodies(s, info)) {
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
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k) {
    for (const Index n : mesh.plate_pair[k]) diagonal[n] += std::max(0.0, -mesh.plate_weight[k]);
  }
  if (!model().has_triangle_stress()) return;
  for (Index t = 0; t < mesh.triangles(); ++t) {
    const Eigen::Matrix<double, 3, 2> rows = corner_gradients(rest_frame(mesh, t));
    const Eigen::Vector3d share = rows.cwiseAbs() * rows.cwiseAbs().colwise().sum().transpose();
    double bound = model().has_strain_limit() ? mesh.limit_stiffness[t] : 0;
    if (model().has_membrane()) {
      const Membrane<double>& m = mesh.membrane[t];
      bound += (1 + material(mesh.triangle[t][0]).strain_damping / dt) * (std::max(m.warp, m.weft) + 2 * m.shear);
    }
    for (int c = 0; c < 3; ++c) diagonal[mesh.triangle[t][c]] += 0.5 * bound * share[c];
  }
}

Vector3d ClothProblem::spring_force(Index e, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const auto [i, j] = mesh.edge[e];
  const Vector3d along = x[i] - x[j];
  const double length = along.norm();
  const Vector3d rest = length > 0 ? Vector3d(mesh.edge_length[e] / length * along) : Vector3d::Zero();
  // Kelvin–Voigt: the rate of stretching along the edge as it lay at the start of the step
  const Vector3d direction = (start[i] - start[j]).normalized();
  const double rate = ((along - (start[i] - start[j])) / dt).dot(direction);
  return -mesh.edge_stiffness[e] * (along - rest + material(i).strain_damping * rate * direction);
}

Vector3d ClothProblem::hinge_force(Index h, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  Vector3d bend = Vector3d::Zero();
  for (int a = 0; a < 4; ++a) bend += mesh.hinge_weight[h][a] * x[mesh.hinge[h][a]];
  return -mesh.hinge_stiffness[h] * bend;
}

Stress ClothProblem::limit_stress(Index t, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const double limit = model().cloths[mesh.triangle_cloth[t]].strain_limit;
  const auto [a, b, c] = mesh.triangle[t];
  Eigen::Matrix<double, 3, 2> edges;
  edges << x[b] - x[a], x[c] - x[a];
  const Eigen::Matrix<double, 3, 2> deformation = edges * rest_frame(mesh, t).inverse();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(deformation, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::Vector2d clamped = svd.singularValues();
  for (double& sigma : clamped) {
    if (sigma > 0) sigma = std::min(std::max(sigma, 1 - limit), 1 + limit);
  }
  const Eigen::Matrix<double, 3, 2> nearest = svd.matrixU() * clamped.asDiagonal() * svd.matrixV().transpose();
  return -mesh.limit_stiffness[t] * (deformation - nearest);
}

Stress ClothProblem::membrane_stress(Index t, const Vectors& x) const {
  const ClothMesh& mesh = model().mesh;
  const Membrane<double>& m = mesh.membrane[t];
  if (m.warp == 0) return Stress::Zero();
  const auto [a, b, c] = mesh.triangle[t];
  // Columns: along warp and weft, then along the lines halfway between them.
  Eigen::Matrix2d axes;
  axes << m.cosine, -m.sine, m.sine, m.cosine;
  const Eigen::Matrix2d diagonals = axes * Eigen::Rotation2Dd(std::numbers::pi / 4).toRotationMatrix();
  const auto columns = [&, a = a, b = b, c = c](const Vectors& at, const Eigen::Matrix2d& directions) {
    Stress edges;
    edges << at[b] - at[a], at[c] - at[a];
    return Stress(edges * rest_frame(mesh, t).inverse() * directions);
  };
  const Stress yarns = columns(x, axes), lines = columns(x, diagonals);  // a second line of diagonals is −(u − v)/√2
  const Stress yarns0 = columns(start, axes), lines0 = columns(start, diagonals);
  const double rate = material(a).strain_damping / dt;
  // Of a stretch: its direction, that at the start of the step, and what it grows by.
  const auto growth = [](const Vector3d& now, const Vector3d& before) {
    return before.stableNormalized().dot(now - before);
  };
  const double wet = 1 + (m.wet - 1) * (node_saturation(state, a) + node_saturation(state, b) + node_saturation(state, c)) / 3;
  Stress along_yarns, along_lines;
  for (int k = 0; k < 2; ++k) {
    const double stiffness = k == 0 ? m.warp : m.weft;
    const Vector3d now = yarns.col(k), before = yarns0.col(k);
    along_yarns.col(k) =
        -stiffness * ((now.norm() - 1) * now.stableNormalized() + rate * growth(now, before) * before.stableNormalized());
  }
  const double shear = lines.col(0).norm() - lines.col(1).norm();
  const double shearing = growth(lines.col(0), lines0.col(0)) - growth(lines.col(1), lines0.col(1));
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1;
    along_lines.col(k) = -m.shear * sign *
                         (shear * lines.col(k).stableNormalized() + rate * shearing * lines0.col(k).stableNormalized());
  }
  return wet * (along_yarns * axes.transpose() + along_lines * diagonals.transpose());
}

Stress ClothProblem::triangle_stress(Index t, const Vectors& x) const {
  Stress sum = Stress::Zero();
  if (model().has_strain_limit()) sum += limit_stress(t, x);
  if (model().has_membrane()) sum += membrane_stress(t, x);
  return sum;
}

Vectors ClothProblem::gathered(const Vectors& spring, const Vectors& hinge, const std::vector<Stress>& triangle) const {
  const ClothMesh& mesh = model().mesh;
  Vectors force(start.size(), Vector3d::Zero());
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    force[mesh.edge[e][0]] += spring[e];
    force[mesh.edge[e][1]] -= spring[e];
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    for (int a = 0; a < 4; ++a) force[mesh.hinge[h][a]] += mesh.hinge_weight[h][a] * hinge[h];
  }
  for (std::size_t t = 0; t < triangle.size(); ++t) {
    const Eigen::Matrix3d f = triangle[t] * corner_gradients(rest_frame(mesh, static_cast<Index>(t))).transpose();
    for (int k = 0; k < 3; ++k) force[mesh.triangle[t][k]] += f.col(k);
  }
  return force;
}

Vectors ClothProblem::internal_force(const Vectors& x) const {
  Vectors spring, hinge;
  for (Index e = 0; e < static_cast<Index>(model().mesh.edge.size()); ++e) spring.push_back(spring_force(e, x));
  for (Index h = 0; h < static_cast<Index>(model().mesh.hinge.size()); ++h) hinge.push_back(hinge_force(h, x));
  std::vector<Stress> triangle;
  for (Index t = 0; model().has_triangle_stress() && t < model().mesh.triangles(); ++t)
    triangle.push_back(triangle_stress(t, x));
  Vectors force = gathered(spring, hinge, triangle);
  add_plates(model().mesh, x, force);
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

Vector3d ClothProblem::before_planes(Index n, const Vector3d& now, Vector3d x) const {
  for (const PlacedBody& body : bodies) {
    Vector3d normal;
    const std::optional<double> distance = distance_to(body, now, normal);
    if (distance) x += std::max(0.0, material(n).thickness - *distance - normal.dot(x - now)) * normal;
  }
  return x;
}

NodeContact ClothProblem::contact(Index n, const Vector3d& x, Vector3d& push, const OfBody& of_body) const {
  NodeContact found;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Vector3d normal;
    const std::optional<double> distance = distance_to(bodies[b], x, normal);
    if (!is_free(n) || !distance || *distance >= contact_range * material(n).thickness) continue;
    const double press = std::max(0.0, -push.dot(normal));
    found = {normal, bodies[b].velocity_at(x), found.press + press};
    push += press * normal;
    if (of_body) of_body(b, -press * normal);
  }
  return found;
}

double ClothProblem::friction(Index n) const {
  const ClothMaterial& m = material(n);
  return m.friction + node_saturation(state, n) * (m.friction_wet - m.friction);
}

Vector3d ClothProblem::with_friction(const NodeContact& contact, Index n, const Vector3d& x, double loss) const {
  const Vector3d way = x - start[n] - dt * contact.surface;
  const Vector3d slip = way - contact.normal * way.dot(contact.normal);
  return x - std::min(1.0, loss / std::max(slip.norm(), 1e-300)) * slip;
}

Vector3d ClothProblem::unbalanced(Index n, const Vector3d& x, const Vector3d& r) const {
  Vector3d left = r;
  const NodeContact touched = contact(n, x, left);
  if (touched.press == 0) return left;
  const Vector3d on = (left - touched.normal * left.dot(touched.normal)) / diagonal[n];
  const Vector3d after = with_friction(touched, n, x + on, friction(n) * touched.press / diagonal[n]);
  return left + diagonal[n] * (after - x - on);
}

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
  rho_ = std::min(rho_, accelerated > 0 ? 1 / std::cosh(std::acosh(3.0) / accelerated) : 0.0);
  if (solver_.method == ClothMethod::pd) return;
  const ClothMesh& mesh = problem.model().mesh;
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    spring_.push_back(problem.spring_force(static_cast<Index>(e), first));
    spring_rate_.push_back(2 / (slowness[mesh.edge[e][0]] + slowness[mesh.edge[e][1]]));
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
  smallest_ = std::numeric_limits<double>::infinity();
}

void ClothIteration::iterate_positions() {
  const Vectors r = problem_.residual(x_);
  Vectors next = x_;
  for (Index n = 0; n < problem_.model().mesh.nodes(); ++n) {
    if (!problem_.is_free(n)) continue;
    Vector3d step = r[n] / problem_.diagonal[n];
    const NodeContact touched = problem_.contact(n, x_[n], step);
    next[n] += step;
    if (touched.press > 0) next[n] = problem_.with_friction(touched, n, next[n], problem_.friction(n) * touched.press);
  }
  problem_.project(next);
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
    const NodeContact touched = problem_.contact(node, previous_[n], step);
    if (touched.press > 0)
      x_[n] = problem_.with_friction(touched, node, previous_[n] + step, problem_.friction(node) * touched.press);
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
  return left > 0 ? left / goal : 0;
}

double ClothIteration::check() {
  const double residual = this->residual();
  if (residual > 10 * smallest_) {
    rho_ = std::max(0.0, 1 - 2 * (1 - rho_));
    since_restart_ = 0;
    plain_ = plain_iterations;
  }
  smallest_ = std::min(smallest_, residual);
  return residual;
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
