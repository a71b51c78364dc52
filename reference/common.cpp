#include "common.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace drench::reference {

using Eigen::Vector3d;

double kernel(double r, double h) {
  const double q = r / h;
  const double sigma = 8 / (std::numbers::pi * h * h * h);
  if (q >= 1) return 0;
  if (q <= 0.5) return sigma * (6 * (q * q * q - q * q) + 1);
  return sigma * 2 * (1 - q) * (1 - q) * (1 - q);
}

Vector3d kernel_gradient(const Vector3d& xij, double h) {
  const double r = xij.norm();
  if (r <= 1e-9 * h || r >= h) return Vector3d::Zero();
  const double q = r / h;
  const double sigma = 8 / (std::numbers::pi * h * h * h);
  const double slope = q <= 0.5 ? sigma / h * 6 * q * (3 * q - 2) : -sigma / h * 6 * (1 - q) * (1 - q);
  return slope / r * xij;
}

double fluid_mass(const ReferenceState& state, Index i) {
  return static_cast<double>(state.s.fluid_mass[i]) * state.model.quantum;
}

double fluid_volume(const ReferenceState& state, Index i) { return fluid_mass(state, i) / state.model.rest_density; }

double node_mass(const ReferenceState& state, Index n) {
  return state.model.mesh.solid_mass[n] + static_cast<double>(state.s.node_liquid[n]) * state.model.quantum;
}

double inverse_node_mass(const ReferenceState& state, Index n) {
  return state.model.mesh.pinned[n] ? 0.0 : 1 / node_mass(state, n);
}

double emission_ramp(const Model& model) {
  double ramp = 0;
  for (const ClothMaterial& cloth : model.cloths) ramp = std::max(ramp, cloth.emission_ramp);
  return ramp;
}

Index sample_node(const ReferenceState& state, Index p, int k) {
  return state.model.mesh.triangle[state.model.samples.triangle[p]][k];
}

Vector3d sample_value(const ReferenceState& state, Index p, const std::vector<Vec3>& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) sum += state.model.samples.weight[p][k] * vec(nodes[sample_node(state, p, k)]);
  return sum;
}

Vector3d sample_value(const ReferenceState& state, Index p, const Vectors& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) sum += state.model.samples.weight[p][k] * nodes[sample_node(state, p, k)];
  return sum;
}

Vector3d sample_position(const ReferenceState& state, Index p) { return sample_value(state, p, state.s.node_position); }

Vector3d sample_velocity(const ReferenceState& state, Index p) { return sample_value(state, p, state.s.node_velocity); }

double sample_saturation(const ReferenceState& state, Index p) {
  const SampleSet& samples = state.model.samples;
  double saturation = 0;
  for (int k = 0; k < 3; ++k) {
    const Index n = sample_node(state, p, k);
    if (samples.node_capacity[n] <= 0) continue;
    const double liquid = static_cast<double>(state.s.node_liquid[n]) * state.model.quantum;
    saturation += samples.weight[p][k] * liquid / samples.node_capacity[n];
  }
  return saturation;
}

Vectors sample_positions(const ReferenceState& state) {
  Vectors positions;
  for (Index p = 0; p < state.model.samples.count(); ++p) positions.push_back(sample_position(state, p));
  return positions;
}

Vectors spread_to_nodes(const ReferenceState& state, const Vectors& sample_force) {
  Vectors force(state.s.node_position.size(), Vector3d::Zero());
  for (Index p = 0; p < static_cast<Index>(sample_force.size()); ++p) {
    for (int k = 0; k < 3; ++k) {
      force[sample_node(state, p, k)] += state.model.samples.weight[p][k] * sample_force[p];
    }
  }
  return force;
}

PressureResponse pressure_response(const ReferenceState& state, const std::vector<double>& kappa) {
  const HostState& s = state.s;
  const double h = state.model.support;
  const Vectors sample = sample_positions(state);
  Vectors sample_force(sample.size(), Vector3d::Zero());
  PressureResponse response;
  response.fluid.assign(s.fluid_position.size(), Vector3d::Zero());
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]);
    Vector3d& a = response.fluid[i];
    for (const Index j : state.fluid_fluid[i]) {
      a -= fluid_volume(state, j) * (kappa[i] + kappa[j]) * kernel_gradient(xi - vec(s.fluid_position[j]), h);
    }
    for (const Index b : state.fluid_boundary[i]) {
      a -= s.boundary_volume[b] * kappa[i] * kernel_gradient(xi - vec(s.boundary_position[b]), h);
    }
    for (const Index b : state.fluid_sample[i]) {
      const Vector3d term = s.sample_volume[b] * kappa[i] * kernel_gradient(xi - sample[b], h);
      a -= term;
      sample_force[b] += fluid_mass(state, i) * term;
    }
  }
  response.node_force = spread_to_nodes(state, sample_force);
  response.node.assign(s.node_position.size(), Vector3d::Zero());
  for (Index n = 0; n < s.node_count(); ++n) {
    const Vector3d& f = response.node_force[n];
    const Vector3d normal = vec(s.node_contact_force[n]);
    response.node[n] = inverse_node_mass(state, n) * (f - normal * std::min(0.0, f.dot(normal)));
  }
  return response;
}

std::vector<double> compression_rate(const ReferenceState& state, const PressureResponse& response, double dt) {
  const HostState& s = state.s;
  const double h = state.model.support;
  const Vectors sample = sample_positions(state);
  Vectors sample_v;
  for (Index p = 0; p < static_cast<Index>(sample.size()); ++p) {
    sample_v.push_back(sample_velocity(state, p) + dt * sample_value(state, p, response.node));
  }
  Vectors v;
  for (Index i = 0; i < s.fluid_count(); ++i) v.push_back(vec(s.fluid_velocity[i]) + dt * response.fluid[i]);

  std::vector<double> rate(v.size(), 0.0);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]);
    for (const Index j : state.fluid_fluid[i]) {
      rate[i] += fluid_volume(state, j) * (v[i] - v[j]).dot(kernel_gradient(xi - vec(s.fluid_position[j]), h));
    }
    for (const Index b : state.fluid_boundary[i]) {
      const Vector3d relative = v[i] - vec(s.boundary_velocity[b]);
      rate[i] += s.boundary_volume[b] * relative.dot(kernel_gradient(xi - vec(s.boundary_position[b]), h));
    }
    for (const Index b : state.fluid_sample[i]) {
      rate[i] += s.sample_volume[b] * (v[i] - sample_v[b]).dot(kernel_gradient(xi - sample[b], h));
    }
  }
  return rate;
}

void apply_response(ReferenceState& state, const PressureResponse& response, double dt) {
  HostState& s = state.s;
  for (Index i = 0; i < s.fluid_count(); ++i) {
    s.fluid_velocity[i] = arr(vec(s.fluid_velocity[i]) + dt * response.fluid[i]);
  }
  for (Index n = 0; n < s.node_count(); ++n) {
    s.node_velocity[n] = arr(vec(s.node_velocity[n]) + dt * response.node[n]);
    if (state.model.mesh.pinned[n]) s.node_pin_force[n] = arr(vec(s.node_pin_force[n]) - response.node_force[n]);
  }
}

}  // namespace drench::reference
