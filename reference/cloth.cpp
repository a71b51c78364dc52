// Stage cloth of the oracle; the law stands in src/stages/cloth.hpp.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision.hpp"
#include "common.hpp"

namespace drench::reference {
namespace {

using Eigen::Vector3d;

constexpr int plain_iterations = 10;  // without acceleration, and between two looks at the residual
constexpr int max_iterations = 300;
constexpr double tolerance = 1e-5;      // of the mean rest edge length
constexpr double contact_range = 1.01;  // of the thickness

const ClothMaterial& material(const Model& m, Index n) { return m.cloths[m.mesh.node_cloth[n]]; }

/// −∂(elastic energy)/∂x_n of all nodes, N.
Vectors elastic_force(const ClothMesh& mesh, const Vectors& x) {
  Vectors force(x.size(), Vector3d::Zero());
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    const auto [i, j] = mesh.edge[e];
    const Vector3d along = x[i] - x[j];
    const double length = along.norm();
    const Vector3d rest = length > 0 ? Vector3d(mesh.edge_length[e] / length * along) : Vector3d::Zero();
    const Vector3d f = mesh.edge_stiffness[e] * (along - rest);
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
  return force;
}

/// The elastic part of the Jacobi diagonal: half the absolute row sums, N/m.
std::vector<double> elastic_diagonal(const ClothMesh& mesh) {
  std::vector<double> diagonal(mesh.nodes(), 0.0);
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    for (const Index n : mesh.edge[e]) diagonal[n] += mesh.edge_stiffness[e];
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    double sum = 0;
    for (const double weight : mesh.hinge_weight[h]) sum += std::abs(weight);
    for (int a = 0; a < 4; ++a) {
      diagonal[mesh.hinge[h][a]] += 0.5 * mesh.hinge_stiffness[h] * std::abs(mesh.hinge_weight[h][a]) * sum;
    }
  }
  return diagonal;
}

/// The problem of one step.
struct Problem {
  const Model& model;
  double dt;
  Vectors target;                // y, m
  std::vector<double> mass;      // wet, kg
  std::vector<double> diagonal;  // D, N/m

  bool is_free(Index n) const { return !model.mesh.pinned[n]; }

  /// r, N.
  Vectors residual(const Vectors& x) const {
    Vectors r = elastic_force(model.mesh, x);
    for (Index n = 0; n < model.mesh.nodes(); ++n) r[n] += mass[n] / (dt * dt) * (target[n] - x[n]);
    return r;
  }

  void project(Vectors& x) const {
    for (Index n = 0; n < model.mesh.nodes(); ++n) {
      if (is_free(n)) project_out(model.bodies, material(model, n).thickness, x[n]);
    }
  }

  /// Normal of the last body that the free node n touches at x, 0 if none.
  Vector3d contact_force(Index n, const Vector3d& x) const {
    Vector3d contact = Vector3d::Zero();
    if (!is_free(n)) return contact;
    for (const Body& body : model.bodies) {
      Vector3d normal;
      const std::optional<double> distance = distance_to(body, x, normal);
      if (distance && *distance < contact_range * material(model, n).thickness) contact = normal;
    }
    return contact;
  }

  /// The largest Jacobi displacement that contacts would not take back, m.
  double error(const Vectors& x) const {
    const Vectors r = residual(x);
    double largest = 0;
    for (Index n = 0; n < model.mesh.nodes(); ++n) {
      if (!is_free(n)) continue;
      const Vector3d normal = contact_force(n, x[n]);
      const Vector3d left = r[n] - normal * std::min(0.0, r[n].dot(normal));
      largest = std::max(largest, left.norm() / diagonal[n]);
    }
    return largest;
  }

  /// A bound for the spectral radius of the Jacobi iteration's linear part.
  double spectral_bound() const {
    double bound = 0;
    for (Index n = 0; n < model.mesh.nodes(); ++n) {
      if (is_free(n)) bound = std::max(bound, 1 - mass[n] / (dt * dt * diagonal[n]));
    }
    return bound;
  }
};

Problem make_problem(const ReferenceState& state, double dt) {
  const Model& m = state.model;
  Problem problem{m, dt, Vectors(m.mesh.nodes()), std::vector<double>(m.mesh.nodes()), elastic_diagonal(m.mesh)};
  for (Index n = 0; n < m.mesh.nodes(); ++n) {
    problem.mass[n] = node_mass(state, n);
    problem.diagonal[n] += problem.mass[n] / (dt * dt);
    problem.target[n] = vec(state.s.node_position[n]);
    if (!problem.is_free(n)) continue;
    problem.target[n] +=
        dt * std::exp(-material(m, n).damping * dt) * vec(state.s.node_velocity[n]) + dt * dt * vec(m.scene.gravity);
  }
  return problem;
}

double mean_length(const ClothMesh& mesh) {
  double sum = 0;
  for (const double length : mesh.edge_length) sum += length;
  return sum / static_cast<double>(mesh.edge_length.size());
}

Vectors solve(const Problem& problem, StepReport& report) {
  const double length = mean_length(problem.model.mesh);
  Vectors x = problem.target, previous = x;
  double rho = problem.spectral_bound(), omega = 1;
  double smallest = std::numeric_limits<double>::infinity();
  int since_restart = 0;
  for (int iteration = 1; iteration <= max_iterations; ++iteration) {
    ++since_restart;
    if (since_restart <= plain_iterations)
      omega = 1;
    else if (since_restart == plain_iterations + 1)
      omega = 2 / (2 - rho * rho);
    else
      omega = 4 / (4 - rho * rho * omega);

    const Vectors r = problem.residual(x);
    Vectors next = x;
    for (Index n = 0; n < problem.model.mesh.nodes(); ++n) {
      if (problem.is_free(n)) next[n] += r[n] / problem.diagonal[n];
    }
    problem.project(next);
    for (Index n = 0; n < problem.model.mesh.nodes(); ++n) next[n] = omega * (next[n] - previous[n]) + previous[n];
    problem.project(next);
    previous = x;
    x = next;

    report.cloth_iterations = iteration;
    if (iteration % plain_iterations != 0) continue;
    const double error = problem.error(x);
    report.cloth_residual = error / length;
    report.cloth_converged = error <= tolerance * length;
    if (report.cloth_converged) break;
    if (error > 10 * smallest) {
      rho = std::max(0.0, 1 - 2 * (1 - rho));
      since_restart = 0;
    }
    smallest = std::min(smallest, error);
  }
  return x;
}

/// v after Coulomb friction: the tangential part falls by at most `speed` (m/s).
Vector3d slowed(const Vector3d& v, const Vector3d& normal, double speed) {
  const Vector3d across = normal * v.dot(normal);
  const Vector3d along = v - across;
  const double length = along.norm();
  return length > speed ? Vector3d(across + along * (1 - speed / length)) : across;
}

}  // namespace

void cloth(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const Model& m = state.model;
  const Problem problem = make_problem(state, info.dt);
  const Vectors x = solve(problem, report);
  const Vectors r = problem.residual(x);
  const Vectors elastic = elastic_force(m.mesh, x);
  for (Index n = 0; n < m.mesh.nodes(); ++n) {
    state.s.node_contact_force[n] = {0, 0, 0};
    if (!problem.is_free(n)) {
      const Vector3d load = elastic[n] + problem.mass[n] * vec(m.scene.gravity);
      state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) - load);
      continue;
    }
    Vector3d v = (x[n] - vec(state.s.node_position[n])) / info.dt;
    const Vector3d normal = problem.contact_force(n, x[n]);
    if (normal.norm() > 0) {
      const double press = std::max(0.0, -r[n].dot(normal));  // N
      v = slowed(v, normal, material(m, n).friction * info.dt * press / problem.mass[n]);
    }
    state.s.node_velocity[n] = arr(v);
    state.s.node_contact_force[n] = arr(normal);
  }
}

}  // namespace drench::reference
