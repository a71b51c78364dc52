#include "common.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/jets.hpp"
#include "state/film.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// dW/dr of r > 0, 1/m⁴.
double kernel_derivative(KernelKind kind, double r, double h) {
  const double pi = std::numbers::pi;
  const double q = r / h;
  if (kind == KernelKind::wendland) return -210 / (pi * std::pow(h, 4)) * q * std::pow(1 - q, 3);
  if (kind == KernelKind::poly6) return -45 / (pi * std::pow(h, 6)) * std::pow(h - r, 2);  // of the spiky kernel
  const double sigma = 8 / (pi * h * h * h);
  return q <= 0.5 ? sigma / h * 6 * q * (3 * q - 2) : -sigma / h * 6 * (1 - q) * (1 - q);
}

}  // namespace

double Smoothing::value(double r) const {
  const double h = h_, q = r / h;
  if (q >= 1) return 0;
  const double pi = std::numbers::pi;
  if (kind_ == KernelKind::wendland) return 10.5 / (pi * h * h * h) * std::pow(1 - q, 4) * (4 * q + 1);
  if (kind_ == KernelKind::poly6) return 315 / (64 * pi * std::pow(h, 9)) * std::pow(h * h - r * r, 3);
  const double sigma = 8 / (pi * h * h * h);
  if (q <= 0.5) return sigma * (6 * (q * q * q - q * q) + 1);
  return sigma * 2 * (1 - q) * (1 - q) * (1 - q);
}

Vector3d Smoothing::gradient(const Vector3d& xij) const {
  const double r = xij.norm();
  if (r <= 1e-9 * h_ || r >= h_) return Vector3d::Zero();
  return kernel_derivative(kind_, r, h_) / r * xij;
}

Vector3d Smoothing::pair_gradient(const Vector3d& xij) const {
  const double r = xij.norm();
  const double steepest = kind_ == KernelKind::cubic ? h_ / 3 : kind_ == KernelKind::wendland ? h_ / 4 : 0;
  if (r <= 1e-9 * h_ || r >= steepest) return gradient(xij);
  return kernel_derivative(kind_, steepest, h_) / r * xij;
}

double fluid_mass(const ReferenceState& state, Index i) {
  return static_cast<double>(state.s.fluid_mass[i]) * state.model.quantum;
}

double fluid_volume(const ReferenceState& state, Index i) { return fluid_mass(state, i) / state.model.rest_density; }

double node_mass(const ReferenceState& state, Index n) {
  return state.model.mesh.solid_mass[n] + static_cast<double>(state.s.node_liquid[n]) * state.model.quantum;
}

double inverse_node_mass(const ReferenceState& state, Index n) {
  return state.model.mesh.is_fixed(n) ? 0.0 : 1 / node_mass(state, n);
}

double inverse_free_mass(const ReferenceState& state, Index n) {
  return state.model.mesh.pinned[n] ? 0.0 : 1 / node_mass(state, n);
}

double emission_ramp(const Model& model) {
  double ramp = 0;
  for (const ClothMaterial& cloth : model.cloths) ramp = std::max(ramp, cloth.emission_ramp);
  return ramp;
}

double source_ramp(const HostState& s, Index i, double ramp) {
  if (s.fluid_origin[i] == static_cast<std::uint8_t>(Origin::mouth)) return std::min(1.0, s.fluid_age[i] / mouth_ramp);
  if (s.fluid_origin[i] != static_cast<std::uint8_t>(Origin::cloth) || ramp <= 0) return 1;
  return std::min(1.0, s.fluid_age[i] / ramp);
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

double pore_capacity(const ReferenceState& state, Index n) {
  return state.node_pores.empty() ? state.model.samples.node_capacity[n] : state.node_pores[n];
}

double most_liquid(const ReferenceState& state, Index n) {
  const double at_rest = state.model.samples.node_capacity[n], most = ceiling_of_node(state.model, n);
  if (state.node_pores.empty()) return most * at_rest;
  const bool film = state.model.material_of_node(n).film_depth > 0;  // it does not shrink with the pores
  return state.node_pores[n] + (most - 1) * (film ? at_rest : state.node_pores[n]);
}

double sample_saturation(const ReferenceState& state, Index p) {
  const SampleSet& samples = state.model.samples;
  double saturation = 0;
  for (int k = 0; k < 3; ++k) {
    const Index n = sample_node(state, p, k);
    if (samples.node_capacity[n] <= 0) continue;
    const double liquid = static_cast<double>(state.s.node_liquid[n]) * state.model.quantum;
    saturation += samples.weight[p][k] * liquid / pore_capacity(state, n);
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

Vector3d from_behind(const ReferenceState& state, Index i, Index b) {
  const auto corner = [&](int k) { return vec(state.s.node_position[sample_node(state, b, k)]); };
  const Vector3d across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
  const Vector3d normal = across.norm() > 0 ? Vector3d(across / across.norm()) : Vector3d::Zero();
  const Vector3d r = vec(state.s.fluid_position[i]) - sample_position(state, b);
  return r + (r.dot(normal) < 0 ? -0.5 : 0.5) * state.model.spacing * normal;
}

void clear_inactive(ReferenceState& state) {
  for (std::size_t i = 0; i < state.alpha.size(); ++i) {
    if (state.alpha[i] == 0) state.s.fluid_kappa_density[i] = 0;
  }
}

PressureResponse pressure_response(const ReferenceState& state, const std::vector<double>& kappa) {
  return pressure_response(state, kappa, std::vector<double>(kappa.size(), 0.0));
}

PressureResponse pressure_response(const ReferenceState& state, const std::vector<double>& kappa,
                                   const std::vector<double>& push) {
  const HostState& s = state.s;
  const Smoothing w(state.model);
  Vectors sample_force(s.sample_volume.size(), Vector3d::Zero());
  PressureResponse response;
  response.fluid.assign(s.fluid_position.size(), Vector3d::Zero());
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]);
    Vector3d& a = response.fluid[i];
    for (const Index j : state.fluid_fluid[i]) {
      a -= fluid_volume(state, j) * (kappa[i] + kappa[j]) * w.pair_gradient(xi - vec(s.fluid_position[j]));
    }
    for (const Index b : state.fluid_boundary[i]) {
      a -= wall_share * s.boundary_volume[b] * kappa[i] * w.gradient(xi - vec(s.boundary_position[b]));
    }
    for (const Index b : state.fluid_sample[i]) {
      const double share = wall_share * image_density(s.fluid_density_ratio[i]) * s.sample_volume[b];
      const Vector3d term = share * (kappa[i] + push[i]) * w.gradient(from_behind(state, i, b));
      a -= term;
      sample_force[b] += fluid_mass(state, i) * term;
    }
    if (!state.wall_gain.empty()) a = state.wall_gain[i] * a;
  }
  response.node_force = spread_to_nodes(state, sample_force);
  return response;
}

Vectors FreeCloth::velocities(const Vectors& node_force) {
  Vectors v;
  for (Index n = 0; n < state_.s.node_count(); ++n) {
    const Vector3d& f = node_force[n];
    const Vector3d contact = vec(state_.s.node_contact_force[n]);
    const Vector3d normal = contact.norm() > 0 ? Vector3d(contact / contact.norm()) : Vector3d::Zero();
    const Vector3d a = inverse_node_mass(state_, n) * (f - normal * std::min(0.0, f.dot(normal)));
    v.push_back(vec(state_.s.node_velocity[n]) + dt_ * a);
  }
  return v;
}

void FreeCloth::accept(ReferenceState& state, const Vectors& node_force) {
  const Vectors v = velocities(node_force);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    state.s.node_velocity[n] = arr(v[n]);
    if (state.model.mesh.is_fixed(n)) state.s.node_pin_force[n] = arr(vec(state.s.node_pin_force[n]) - node_force[n]);
  }
}

std::vector<double> approach_rate(const ReferenceState& state, const Vectors& v, const Vectors& node) {
  const HostState& s = state.s;
  const Smoothing w(state.model);
  Vectors sample_v;
  for (Index p = 0; p < s.sample_count(); ++p) sample_v.push_back(sample_value(state, p, node));
  std::vector<double> rate(v.size(), 0.0);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    for (const Index b : state.fluid_sample[i]) {
      const double share = wall_share * image_density(s.fluid_density_ratio[i]) * s.sample_volume[b];
      rate[i] += share * (v[i] - sample_v[b]).dot(w.gradient(from_behind(state, i, b)));
    }
  }
  return rate;
}

std::vector<double> density_rate(const ReferenceState& state, const Vectors& v, const Vectors& node) {
  const HostState& s = state.s;
  const Smoothing w(state.model);
  std::vector<double> rate = approach_rate(state, v, node);
  for (Index i = 0; i < s.fluid_count(); ++i) {
    const Vector3d xi = vec(s.fluid_position[i]);
    for (const Index j : state.fluid_fluid[i]) {
      rate[i] += fluid_volume(state, j) * (v[i] - v[j]).dot(w.pair_gradient(xi - vec(s.fluid_position[j])));
    }
    for (const Index b : state.fluid_boundary[i]) {
      const Vector3d relative = v[i] - state.boundary_predicted[b];
      rate[i] += wall_share * s.boundary_volume[b] * relative.dot(w.gradient(xi - vec(s.boundary_position[b])));
    }
  }
  return rate;
}

}  // namespace drench::reference
