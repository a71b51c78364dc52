#include "transfer.hpp"

#include <algorithm>

#include "state/film.hpp"

namespace drench::reference {

Momentum momentum_of(double quanta, const Eigen::Vector3d& velocity) {
  Momentum p;
  for (int a = 0; a < 3; ++a) p[a] = std::llround(quanta * velocity[a] * momentum_steps);
  return p;
}

void add(Momentum& sum, const Momentum& part) {
  for (int a = 0; a < 3; ++a) sum[a] += part[a];
}

std::array<Quanta, 3> split_over_nodes(const std::array<double, 3>& weight, Quanta quanta) {
  std::array<Quanta, 3> part;
  Quanta rest = quanta;
  for (int k = 0; k < 3; ++k) {
    part[k] = floor_quanta(weight[k] * static_cast<double>(quanta));
    rest -= part[k];
  }
  part[std::max_element(weight.begin(), weight.end()) - weight.begin()] += rest;
  return part;
}

Quanta solute_part(Quanta solute, Quanta part, Quanta liquid) {
  if (part <= 0 || solute <= 0) return 0;
  __extension__ using Wide = __int128;
  return static_cast<Quanta>(static_cast<Wide>(solute) * part / liquid);
}

std::array<Quanta, 3> split_solute(Quanta solute, const std::array<Quanta, 3>& part) {
  const Quanta liquid = part[0] + part[1] + part[2];
  std::array<Quanta, 3> result;
  Quanta rest = solute;
  for (int k = 0; k < 3; ++k) {
    result[k] = solute_part(solute, part[k], liquid);
    rest -= result[k];
  }
  result[std::max_element(part.begin(), part.end()) - part.begin()] += rest;
  return result;
}

void give_solute_to_nodes(ReferenceState& state, const std::vector<Quanta>& solute, const std::vector<Quanta>& quanta,
                          const std::vector<Split>& split) {
  if (!state.model.has_solute()) return;
  for (Index p = 0; p < state.model.samples.count(); ++p) {
    if (solute[p] == 0) continue;
    const std::array<Quanta, 3> part = split_solute(solute[p], split_over_nodes(split[p].weight, quanta[p]));
    for (int k = 0; k < 3; ++k) state.s.node_solute[sample_node(state, p, k)] += part[k];
  }
}

std::vector<Quanta> gather_at_nodes(const ReferenceState& state, const std::vector<Quanta>& at_samples) {
  std::vector<Quanta> sum(state.s.node_count(), 0);
  for (Index p = 0; p < state.model.samples.count(); ++p) {
    for (int k = 0; k < 3; ++k) {
      sum[sample_node(state, p, k)] +=
          floor_quanta(state.model.samples.weight[p][k] * static_cast<double>(at_samples[p]));
    }
  }
  return sum;
}

/// φ_n, 1: which part of what comes node n takes without rising above s_max.
std::vector<double> node_inflow_limit(const ReferenceState& state, const std::vector<Quanta>& in) {
  const Model& m = state.model;
  const std::vector<Quanta> inflow = gather_at_nodes(state, in);
  std::vector<double> phi(state.s.node_count(), 1.0);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const Quanta full = floor_quanta(most_liquid(state, n) / m.quantum);
    // The last two terms absorb what rounding adds to single nodes.
    const Quanta room = full - state.s.node_liquid[n] - (inflow[n] >> 16) - 1024;
    if (inflow[n] > room && inflow[n] > 0) {
      phi[n] = static_cast<double>(std::max<Quanta>(0, room)) / static_cast<double>(inflow[n]);
    }
  }
  return phi;
}

std::vector<Split> inflow_split(const ReferenceState& state, const std::vector<Quanta>& in, bool is_limited) {
  const std::vector<double> phi =
      is_limited ? node_inflow_limit(state, in) : std::vector<double>(state.s.node_count(), 1.0);
  std::vector<Split> result;
  for (Index p = 0; p < state.model.samples.count(); ++p) {
    Split split{state.model.samples.weight[p], 1};
    std::array<double, 3> taken;
    bool any_limited = false;
    for (int k = 0; k < 3; ++k) {
      const double f = phi[sample_node(state, p, k)];
      any_limited = any_limited || (split.weight[k] > 0 && f < 1);
      taken[k] = split.weight[k] * f;
    }
    if (any_limited) {
      split.share = taken[0] + taken[1] + taken[2];
      for (int k = 0; k < 3 && split.share > 0; ++k) split.weight[k] = taken[k] / split.share;
    }
    result.push_back(split);
  }
  return result;
}

void give_to_nodes(ReferenceState& state, const std::vector<Quanta>& quanta, const std::vector<Momentum>& momentum,
                   const std::vector<Split>& split, double dt) {
  const SampleSet& samples = state.model.samples;
  std::vector<Quanta> mass(state.s.node_count(), 0);
  Vectors push(state.s.node_count(), Eigen::Vector3d::Zero());  // q · 2^-8 m/s, no longer whole numbers
  for (Index p = 0; p < samples.count(); ++p) {
    const std::array<Quanta, 3> part = split_over_nodes(split[p].weight, quanta[p]);
    for (int k = 0; k < 3; ++k) {
      const Index n = sample_node(state, p, k);
      mass[n] += part[k];
      for (int a = 0; a < 3; ++a) {
        push[n][a] += split[p].weight[k] * static_cast<double>(momentum[p][a]);
      }
    }
  }
  const double unit = state.model.quantum / momentum_steps;  // kg m/s
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const double before = node_mass(state, n);
    state.s.node_liquid[n] += mass[n];
    if (mass[n] == 0 && push[n].isZero(0)) continue;
    const double gained = static_cast<double>(mass[n]) * state.model.quantum, after = before + gained;
    if (state.model.mesh.is_fixed(n)) {
      Vec3& pin = state.s.node_pin_force[n];
      pin = arr(vec(pin) - (unit * push[n] - gained * vec(state.s.node_velocity[n])) / dt);
      continue;
    }
    for (int a = 0; a < 3; ++a) {
      double& v = state.s.node_velocity[n][a];
      v = (before * v + push[n][a] * unit) / after;
    }
  }
}

void push_nodes(ReferenceState& state, const std::vector<Momentum>& momentum, double dt) {
  const double unit = state.model.quantum / momentum_steps;  // kg m/s
  for (Index n = 0; n < state.s.node_count(); ++n) {
    for (int a = 0; a < 3; ++a) {
      const double p = static_cast<double>(momentum[n][a]) * unit;
      state.s.node_velocity[n][a] += p * inverse_node_mass(state, n);
      if (state.model.mesh.is_fixed(n)) state.s.node_pin_force[n][a] -= p / dt;
    }
  }
}

void remove_particles(HostState& s, const std::vector<bool>& gone) {
  visit_fields(s, [&](std::string_view field, auto& array) {
    if (!field.starts_with("fluid_")) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (!gone[i]) array[kept++] = array[i];
    }
    array.resize(kept);
  });
}

void count_on_face(ReferenceState& state, Index p, const Eigen::Vector3d& x, Quanta quanta, int direction) {
  HostState& s = state.s;
  if (s.sample_taken_front.empty()) return;
  const bool front = (x - sample_position(state, p)).dot(sample_normal(state, p)) >= 0;
  auto& account = direction > 0 ? (front ? s.sample_taken_front : s.sample_taken_back)
                                : (front ? s.sample_given_front : s.sample_given_back);
  account[p] += quanta;
}

bool is_porous(const ReferenceState& state, Index p) { return state.model.material_of_sample(p).porous; }

bool is_permeable(const ReferenceState& state, Index p) {
  return state.model.has_permeation() && state.model.material_of_sample(p).conductance > 0;
}

double flux_through(const ClothMaterial& cloth, double drive) {
  const double g = cloth.conductance, loss = cloth.inertial_loss;
  if (loss == 0) return g * drive;
  // The root of u / g + loss u |u| = drive.
  const double u = (std::sqrt(1 / (g * g) + 4 * loss * std::fabs(drive)) - 1 / g) / (2 * loss);
  return std::copysign(u, drive);
}

bool is_driven(const ReferenceState& state, Index p) {
  if (!is_permeable(state, p)) return false;
  const ClothMaterial& cloth = state.model.material_of_sample(p);
  return std::fabs(state.sample_passing[p]) > flux_through(cloth, cloth.entry_potential);
}

bool same_layer(const ReferenceState& state, Index p, Index q) {
  const SampleSet& samples = state.model.samples;
  if (samples.cloth[p] != samples.cloth[q]) return false;
  return (vec(samples.rest_position[p]) - vec(samples.rest_position[q])).norm() < 2 * state.model.support;
}

}  // namespace drench::reference
