#include "watched_energy.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "base/eigen_vec.hpp"
#include "setup/smoothing_kernel.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

Vector3d node(const HostState& s, Index n) { return to_eigen(s.node_position[static_cast<std::size_t>(n)]); }

double node_mass(const Model& m, const HostState& s, std::size_t n) {
  return m.mesh.solid_mass[n] + kilograms(m, s.node_liquid[n]);
}

/// Of a kilogram in gravity, J/kg.
double height_energy(const Model& m, const Vector3d& x) { return -to_eigen(m.scene.gravity).dot(x); }

double particle_energy(const Model& m, const HostState& s, std::size_t i) {
  const Vector3d x = to_eigen(s.fluid_position[i]);
  double energy = 0.5 * to_eigen(s.fluid_velocity[i]).squaredNorm() + height_energy(m, x);
  if (m.scene.field.present)
    energy += 0.5 * (x - to_eigen(m.scene.field.center)).cwiseProduct(to_eigen(m.scene.field.rate)).squaredNorm();
  return kilograms(m, s.fluid_mass[i]) * energy;
}

/// ½ w A |F − F*|² of every triangle with a strain limit.
double limit_energy(const Model& m, const HostState& s) {
  double energy = 0;
  for (std::size_t t = 0; m.has_strain_limit() && t < m.mesh.triangle.size(); ++t) {
    const double limit = m.cloths[static_cast<std::size_t>(m.mesh.triangle_cloth[t])].strain_limit;
    if (limit <= 0) continue;
    const auto& [a, b, c] = m.mesh.triangle[t];
    const auto& shape = m.mesh.triangle_shape[t];
    Eigen::Matrix<double, 3, 2> edges;
    edges << node(s, b) - node(s, a), node(s, c) - node(s, a);
    Eigen::Matrix2d inverse;
    inverse << shape[0], shape[1], 0, shape[2];
    const Eigen::VectorXd sigma = Eigen::MatrixXd(edges * inverse).jacobiSvd().singularValues();
    for (const double x : sigma)
      if (x > 0) energy += 0.5 * m.mesh.limit_stiffness[t] * std::pow(x - std::clamp(x, 1 - limit, 1 + limit), 2);
  }
  return energy;
}

/// Of membranes, dry: as stretch and shear of each triangle; and of plates, by their pairs.
double woven_energy(const Model& m, const HostState& s) {
  double energy = 0;
  for (std::size_t t = 0; t < m.mesh.membrane.size(); ++t) {
    const Membrane<double>& k = m.mesh.membrane[t];
    const auto& [a, b, c] = m.mesh.triangle[t];
    const auto& shape = m.mesh.triangle_shape[t];
    Eigen::Matrix<double, 3, 2> edges;
    edges << node(s, b) - node(s, a), node(s, c) - node(s, a);
    Eigen::Matrix2d inverse, axes;
    inverse << shape[0], shape[1], 0, shape[2];
    axes << k.cosine, -k.sine, k.sine, k.cosine;
    const Eigen::Matrix<double, 3, 2> yarns = edges * inverse * axes;
    const double shear = ((yarns.col(0) + yarns.col(1)).norm() - (yarns.col(0) - yarns.col(1)).norm()) / std::sqrt(2.0);
    const auto yarn = [](double e, double lock) {
      if (!(lock > 0 && e > 0)) return e * e;
      const double at = std::min(e, locking_part * lock), left = 1 - at * at / (lock * lock);
      return -lock * lock * std::log(left) + 2 * at / left * (e - at) +
             (2 - left) / (left * left) * (e - at) * (e - at);
    };
    energy += 0.5 * (k.warp * yarn(yarns.col(0).norm() - 1, k.warp_locking) +
                     k.weft * yarn(yarns.col(1).norm() - 1, k.weft_locking) + k.shear * shear * shear);
  }
  for (std::size_t k = 0; k < m.mesh.plate_pair.size(); ++k)
    energy -= 0.5 * m.mesh.plate_weight[k] *
              (node(s, m.mesh.plate_pair[k][0]) - node(s, m.mesh.plate_pair[k][1])).squaredNorm();
  return energy;
}

double body_energy(const Model& m, const HostState& s, std::size_t b) {
  const Body& body = m.bodies[b];
  const auto& q = s.body_orientation[b];
  const Vector3d axis(q[1], q[2], q[3]), spin = to_eigen(s.body_angular_velocity[b]);
  const Eigen::Matrix3d turned = Eigen::Quaterniond(q[0], axis[0], axis[1], axis[2]).toRotationMatrix();
  const Vector3d own = turned.transpose() * spin;
  return body.mass *
             (0.5 * to_eigen(s.body_velocity[b]).squaredNorm() + height_energy(m, to_eigen(s.body_position[b]))) +
         0.5 * own.cwiseProduct(own).dot(to_eigen(body.inertia));
}

/// m: how far liquid is carried at most between a particle and the nodes that it goes to, or from node to node.
double reach(const Model& m, const HostState& s) {
  double longest = 0;
  for (const auto& [a, b] : m.mesh.edge) longest = std::max(longest, (node(s, a) - node(s, b)).norm());
  return m.support + longest;
}

/// Does a particle that was there arrive at the domain's border in a step?
bool leaves(const Model& m, const HostState& s, std::size_t i, double dt) {
  const double margin =
      m.spacing + 2 * dt * to_eigen(s.fluid_velocity[i]).norm() + dt * dt * to_eigen(m.scene.gravity).norm();
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = s.fluid_position[i][a];
    if (x - margin < m.scene.domain.min[a] || x + margin > m.scene.domain.max[a]) return true;
  }
  return false;
}

}  // namespace

double elastic_energy(const Model& m, const HostState& s) {
  if (!m.has_moving_cloth()) return 0;
  const ClothMesh& mesh = m.mesh;
  double energy = limit_energy(m, s) + woven_energy(m, s);
  for (std::size_t e = 0; e < mesh.edge.size(); ++e) {
    const double stretch = (node(s, mesh.edge[e][0]) - node(s, mesh.edge[e][1])).norm() - mesh.edge_length[e];
    energy += 0.5 * mesh.edge_stiffness[e] * stretch * stretch;
  }
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    Vector3d bend = Vector3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) bend += mesh.hinge_weight[h][a] * node(s, mesh.hinge[h][a]);
    energy += 0.5 * mesh.hinge_stiffness[h] * bend.squaredNorm();
  }
  return energy;
}

double mechanical_energy(const Model& m, const HostState& s) {
  double energy = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i) energy += particle_energy(m, s, i);
  for (std::size_t n = 0; n < s.node_position.size(); ++n)
    energy += node_mass(m, s, n) *
              (0.5 * to_eigen(s.node_velocity[n]).squaredNorm() + height_energy(m, to_eigen(s.node_position[n])));
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    if (m.bodies[b].dynamic) energy += body_energy(m, s, b);
  return energy + elastic_energy(m, s);
}

EnergyInput energy_input(const Model& m, const HostState& before, const HostState& now, double dt) {
  EnergyInput in;
  for (std::size_t n = 0; n < m.mesh.pin_motion.size(); ++n) {
    if (m.mesh.pin_motion[n] < 0) continue;
    in.pins += to_eigen(now.node_pin_force[n]).dot(to_eigen(now.node_position[n]) - to_eigen(before.node_position[n]));
  }
  const std::unordered_set<std::int64_t> old(before.fluid_id.begin(), before.fluid_id.end());
  for (std::size_t i = 0; i < now.fluid_id.size(); ++i) {
    const auto origin = static_cast<Origin>(now.fluid_origin[i]);
    if ((origin != Origin::jet && origin != Origin::mouth) || old.contains(now.fluid_id[i])) continue;
    in.jets += particle_energy(m, now, i);
    in.jet_motion += 0.5 * kilograms(m, now.fluid_mass[i]) * to_eigen(now.fluid_velocity[i]).squaredNorm();
  }
  const std::unordered_set<std::int64_t> left(now.fluid_id.begin(), now.fluid_id.end());
  for (std::size_t i = 0; i < before.fluid_id.size(); ++i) {
    if (left.contains(before.fluid_id[i])) continue;
    if (now.drained > before.drained && leaves(m, before, i, dt))
      in.drained += particle_energy(m, before, i);
    else
      ++in.absorbed;
  }
  double moved = 0;  // kg
  for (std::size_t n = 0; n < now.node_liquid.size(); ++n)
    moved += kilograms(m, std::abs(now.node_liquid[n] - before.node_liquid[n]));
  if (moved > 0) in.exchanged = moved * to_eigen(m.scene.gravity).norm() * reach(m, now);
  return in;
}

double motion_energy(const Model& m, const HostState& s) {
  double energy = 0;
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    energy += 0.5 * kilograms(m, s.fluid_mass[i]) * to_eigen(s.fluid_velocity[i]).squaredNorm();
  for (std::size_t n = 0; n < s.node_position.size(); ++n)
    energy += 0.5 * node_mass(m, s, n) * to_eigen(s.node_velocity[n]).squaredNorm();
  return energy;
}

double correction(const Model& m, const HostState& s, double dt) {
  const auto& solver = m.scene.fluid.solver;
  double mass = 0;
  for (const Quanta q : s.fluid_mass) mass += kilograms(m, q);
  if (!(mass > 0)) return 0;
  // How much denser than at rest the lattice is that a block starts as.
  const double lattice = std::max(0.0, lattice_density(m.scene.fluid.kernel, m.support / m.spacing) - 1);
  const double off = std::max({solver.density_error, solver.divergence_error, solver.density_correction * lattice}),
               speed = off * m.support / dt;
  return 0.5 * mass * speed * speed;
}

double sway(const Model& m, const HostState& s, double dt) {
  double energy = 0;
  if (m.scene.field.present)
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vector3d pull = (to_eigen(s.fluid_position[i]) - to_eigen(m.scene.field.center))
                                .cwiseProduct(to_eigen(m.scene.field.rate).cwiseAbs2());
      energy += 0.5 * dt * kilograms(m, s.fluid_mass[i]) * std::abs(pull.dot(to_eigen(s.fluid_velocity[i])));
    }
  return energy;
}

double weight(const Model& m, const HostState& s) {
  double mass = 0;
  for (const Quanta q : s.fluid_mass) mass += kilograms(m, q);
  for (std::size_t n = 0; n < s.node_position.size(); ++n) mass += node_mass(m, s, n);
  return mass * to_eigen(m.scene.gravity).norm();
}

}  // namespace drench::test
