// Stage forces (src/stages/forces.hpp).

#include <algorithm>
#include <cmath>

#include "deforming_body.hpp"
#include "rigid_bodies.hpp"
#include "sheets.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// χ of the viscosity, 1.
double normalisation(KernelKind kind) {
  if (kind == KernelKind::wendland) return 30;
  if (kind == KernelKind::poly6) return 28;
  return 80.0 / 3;
}

/// The planes that samples stand for where a wall slips.
struct Wall {
  Vector3d normal = Vector3d::Zero();
  double depth = 0;    // m: of the sample below it
  bool sides = false;  // two of them: of sheets and open meshes
  double slip = 0;     // b, m
  double nearest = 0;  // m: no particle counts as nearer

  /// What a pair at x = x_i − x_b (m) with v = v_i − v_b (m/s) does to particle i, m/s²; `factor`: all but v, x and ∇W.
  Vector3d pull(double factor, const Vector3d& v, const Vector3d& x, const Vector3d& gradient) const {
    const Vector3d held = factor * v.dot(x) * gradient;
    if (slip == 0) return held;
    const double f = stick(x);
    return f * held + (1 - f) * factor * v.dot(normal) * x.dot(normal) * gradient.dot(normal) * normal;
  }
  /// How fast it can slow particle i at most, 1/s.
  double bound(double factor, const Vector3d& x, const Vector3d& gradient) const {
    const double held = factor * gradient.norm() * x.norm();
    if (slip == 0) return held;
    const double f = stick(x);
    return f * held + (1 - f) * factor * std::abs(x.dot(normal) * gradient.dot(normal));
  }

 private:
  /// f: the share of the force without slip that is left.
  double stick(const Vector3d& x) const {
    const double along = x.dot(normal), distance = std::max(nearest, (sides ? std::abs(along) : along) - depth);
    return std::isinf(slip) ? 0.0 : distance / (distance + slip);
  }
};

struct Walls {
  std::vector<Wall> boundary, sample;
};

/// Unit normals of a body's samples at a time, s.
Vectors wall_normals(const ReferenceState& state, Index body, double time) {
  const Body& b = state.model.bodies[body];
  Vectors normals;
  if (b.deforms()) {
    const Vectors points = shape_points(b, time);
    for (Index s = 0; s < b.sample_count; ++s) {
      const auto& t = b.mesh_triangles[b.shape.triangle[s]];
      normals.push_back((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized());
    }
    return normals;
  }
  const Eigen::Quaterniond turned = pose_of(state.s, body).orientation;
  for (Index s = 0; s < b.sample_count; ++s)
    normals.push_back(turned * vec(state.model.boundary.wall_normal[b.first_sample + s]));
  return normals;
}

Walls walls_of(const ReferenceState& state, double time) {
  const Model& m = state.model;
  Walls walls{std::vector<Wall>(state.s.boundary_position.size()), std::vector<Wall>(state.s.sample_count())};
  for (Index k = 0; k < state.s.body_count() && m.has_slipping_body(); ++k) {
    const Vectors normals = wall_normals(state, k, time);
    for (Index s = 0; s < m.bodies[k].sample_count; ++s) {
      const Index b = m.bodies[k].first_sample + s;
      const double depth = m.boundary.wall_depth[b];
      walls.boundary[b] = {normals[s], depth, depth == 0, m.bodies[k].slip, m.spacing / 4};
    }
  }
  for (Index p = 0; p < state.s.sample_count(); ++p)
    walls.sample[p] = {sample_normal(state, p), 0, true, m.cloths[m.samples.cloth[p]].slip, m.spacing / 4};
  return walls;
}

struct Velocities {
  Vectors fluid, sample, boundary;
};

/// L(v) of the liquid in m/s², the forces on the samples in N, and the bounds C_i in 1/s and K_b in kg/s.
struct Rates {
  Vectors fluid, sample_force, body_force;
  std::vector<double> fluid_bound, sample_bound, body_bound;
};

/// g and the scene's central field at particle i, m/s².
Vector3d given_acceleration(const ReferenceState& state, Index i) {
  const Scene& scene = state.model.scene;
  Vector3d a = vec(scene.gravity);
  if (!scene.field.present) return a;
  for (std::size_t k = 0; k < 3; ++k) {
    const double rate = scene.field.rate[k];
    a[static_cast<Index>(k)] -= rate * rate * (state.s.fluid_position[i][k] - scene.field.center[k]);
  }
  return a;
}

Rates rates(const ReferenceState& state, const Walls& walls, const Velocities& v) {
  const HostState& s = state.s;
  const double h = state.model.support;
  const Smoothing w(state.model);
  const double strength = normalisation(state.model.scene.fluid.kernel) * state.model.scene.fluid.viscosity / (h * h);
  const Vectors sample = sample_positions(state);
  const auto ratio = [&](Index i) { return std::max(0.5, s.fluid_density_ratio[i]); };
  Rates out;
  out.sample_force.assign(sample.size(), Vector3d::Zero());
  out.sample_bound.assign(sample.size(), 0.0);
  out.body_force.assign(s.boundary_position.size(), Vector3d::Zero());
  out.body_bound.assign(s.boundary_position.size(), 0.0);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    Vector3d a = given_acceleration(state, i);
    double bound = 0;
    const Vector3d xi = vec(s.fluid_position[i]), vi = v.fluid[i];
    const auto add = [&](const Wall& wall, double factor, const Vector3d& velocity, const Vector3d& x,
                         const Vector3d& gradient) {
      const Vector3d term = wall.pull(strength * factor, velocity, x, gradient);
      a += term;
      bound += wall.bound(strength * factor, x, gradient);
      return term;
    };
    for (const Index j : state.fluid_fluid[i]) {
      const Vector3d x = xi - vec(s.fluid_position[j]);
      add({}, fluid_volume(state, j) / std::sqrt(ratio(i) * ratio(j)), vi - v.fluid[j], x, w.pair_gradient(x));
    }
    for (const Index b : state.fluid_boundary[i]) {
      const double before = bound;
      const Vector3d x = xi - vec(s.boundary_position[b]);
      const Vector3d term =
          add(walls.boundary[b], 2 * s.boundary_volume[b] / ratio(i), vi - v.boundary[b], x, w.gradient(x));
      out.body_force[b] -= fluid_mass(state, i) * term;
      out.body_bound[b] += fluid_mass(state, i) * (bound - before);
    }
    for (const Index b : state.fluid_sample[i]) {
      const double before = bound;
      const Vector3d x = xi - sample[b];
      const Vector3d term =
          add(walls.sample[b], 0.57 * s.sample_volume[b] / ratio(i), vi - v.sample[b], x, w.gradient(x));
      out.sample_force[b] -= fluid_mass(state, i) * term;
      out.sample_bound[b] += fluid_mass(state, i) * (bound - before);
    }
    out.fluid.push_back(a);
    out.fluid_bound.push_back(bound);
  }
  return out;
}

/// The largest of C_i and u_n Σ_b w_bn K_b, 1/s.
double largest_bound(const ReferenceState& state, const Rates& rates) {
  const HostState& s = state.s;
  std::vector<double> node(state.s.node_position.size(), 0.0);
  for (Index b = 0; b < static_cast<Index>(rates.sample_bound.size()); ++b) {
    for (int k = 0; k < 3; ++k) {
      node[sample_node(state, b, k)] += state.model.samples.weight[b][k] * rates.sample_bound[b];
    }
  }
  double largest = 0;
  for (const double bound : rates.fluid_bound) largest = std::max(largest, bound);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    largest = std::max(largest, inverse_node_mass(state, n) * node[n]);
  }
  for (Index k = 0; k < s.body_count(); ++k) {
    const Body& body = state.model.bodies[k];
    if (!body.dynamic) continue;
    double push = 0, turn = 0;
    for (Index b = body.first_sample; b < body.first_sample + body.sample_count; ++b) {
      push += rates.body_bound[b];
      turn += rates.body_bound[b] * (vec(s.boundary_position[b]) - vec(s.body_position[k])).squaredNorm();
    }
    largest = std::max({largest, 2 * push / body.mass, 2 * turn / vec(body.inertia).minCoeff()});
  }
  return largest;
}

}  // namespace

void forces(ReferenceState& state, const StepInfo& info, StepReport& report) {
  HostState& s = state.s;
  const std::size_t particles = s.fluid_velocity.size(), nodes = s.node_velocity.size();
  // Y_{k−1} and D_{k−1} of the particles, the same of the nodes' impulses
  Vectors now, change(particles, Vector3d::Zero());
  Vectors impulse(nodes, Vector3d::Zero()), impulse_change = impulse;
  Vectors body_change(s.boundary_position.size(), Vector3d::Zero());  // impulses on the samples of bodies, N s
  Vector3d fall = Vector3d::Zero();
  for (const Vec3& v : s.fluid_velocity) now.push_back(vec(v));
  const Walls walls = walls_of(state, info.time);

  int stages = 1;
  for (int k = 1; k <= stages; ++k) {
    Vectors node_velocity;
    for (std::size_t n = 0; n < nodes; ++n) {
      node_velocity.push_back(vec(s.node_velocity[n]) + inverse_node_mass(state, static_cast<Index>(n)) * impulse[n]);
    }
    Velocities v{now, {}, {}};
    for (const Vec3& u : s.boundary_velocity) v.boundary.push_back(vec(u));
    for (Index b = 0; b < s.sample_count(); ++b) v.sample.push_back(sample_value(state, b, node_velocity));
    const Rates r = rates(state, walls, v);
    if (k == 1) {
      while (stages * (stages + 1.0) < 2 * info.dt * largest_bound(state, r)) ++stages;
      if (state.model.scene.fluid.viscosity > 0) report.viscosity_stages = stages;
    }
    const double keep = (k - 1.0) / k, weight = (2 * k - 1.0) / k * info.dt * 2 / (stages * (stages + 1.0));
    for (std::size_t i = 0; i < particles; ++i) {
      change[i] = keep * change[i] + weight * r.fluid[i];
      now[i] += change[i];
    }
    // The samples' impulses follow the recurrence, and so do the bodies' momenta, their sums.
    fall = keep * fall + weight * vec(state.model.scene.gravity);
    for (Index body = 0; body < s.body_count(); ++body) {
      if (state.model.bodies[body].dynamic) s.body_velocity[body] = arr(vec(s.body_velocity[body]) + fall);
    }
    for (std::size_t b = 0; b < body_change.size(); ++b)
      body_change[b] = keep * body_change[b] + weight * r.body_force[b];
    accelerate_bodies(state, body_change, 1);
    const Vectors node_force = spread_to_nodes(state, r.sample_force);
    for (std::size_t n = 0; n < nodes; ++n) {
      impulse_change[n] = keep * impulse_change[n] + weight * node_force[n];
      impulse[n] += impulse_change[n];
    }
  }

  for (std::size_t i = 0; i < particles; ++i) s.fluid_velocity[i] = arr(now[i]);
  for (std::size_t n = 0; n < nodes; ++n) {
    const double u = inverse_node_mass(state, static_cast<Index>(n));
    s.node_velocity[n] = arr(vec(s.node_velocity[n]) + u * impulse[n]);
    if (state.model.mesh.is_fixed(static_cast<Index>(n)))
      s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - impulse[n] / info.dt);
  }
}

}  // namespace drench::reference
