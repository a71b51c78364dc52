// Stage absorption of the oracle; the law stands in src/stages/absorption.hpp.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "transfer.hpp"

namespace drench::reference {
namespace {

/// What liquid at `away` (m) from sample j is asked for: kg, of pressure alone, and whether the fabric takes liquid up
/// by itself.
struct Passage {
  double driven = 0;
  bool wets = true;
};

Passage passage(const ReferenceState& state, Index i, Index j, double saturation, double dt) {
  const ClothMaterial& cloth = state.model.material_of_sample(j);
  const double flux = state.sample_passing[j];
  const Eigen::Vector3d away = vec(state.s.fluid_position[i]) - sample_position(state, j);
  const bool upstream = is_driven(state, j) && flux * away.dot(sample_normal(state, j)) < 0;
  if (!upstream) return {0, cloth.entry_potential == 0};
  const double relative = std::pow(std::min(1.0, saturation), 3);
  const double weight = fluid_volume(state, i) * Smoothing(state.model).value(away.norm()) / state.sample_supply[j];
  return {dt * state.model.rest_density * state.model.samples.area[j] * std::fabs(flux) * relative * weight, true};
}

/// s̄_ij, 1: the saturation up to which sample j takes liquid that lies where `cosine` says.
double most_from_there(const ReferenceState& state, Index j, double cosine) {
  const ClothMaterial& cloth = state.model.material_of_sample(j);
  const bool passes = is_permeable(state, j) && is_driven(state, j);
  if (cloth.film_depth > 0 && !passes) return cosine > -0.25 ? cloth.max_saturation : 1;
  return is_permeable(state, j) ? 1 : 1 + (cloth.max_saturation - 1) * std::max(0.0, cosine);
}

/// w_ij, kg: what sample j would like to take from particle i.
double demand(const ReferenceState& state, Index i, Index j, double dt) {
  const Model& m = state.model;
  const ClothMaterial& cloth = m.material_of_sample(j);
  const double h = m.support;
  const Eigen::Vector3d xij = sample_position(state, j) - vec(state.s.fluid_position[i]);
  const Eigen::Vector3d direction = vec(state.s.sample_flow_direction[j]);
  const double r = xij.norm();
  double cosine = 0;
  if (direction.norm() > 0 && r > 1e-9 * h) cosine = xij.dot(direction) / (r * direction.norm());
  const double cap = most_from_there(state, j, cosine);
  const bool controlled = m.scene.processes.saturation_control;
  const double deficit = controlled ? std::max(0.0, cap - sample_saturation(state, j)) : 1;
  const double laplacian = 45 * (h - r) / (std::numbers::pi * std::pow(h, 6));  // 1/m⁵
  const double wish = dt * cloth.absorption * m.samples.capacity[j] * deficit * fluid_volume(state, i) * laplacian;
  if (!is_permeable(state, j)) return wish;
  const Passage through = passage(state, i, j, sample_saturation(state, j), dt);
  return (through.wets ? wish : 0) + through.driven;
}

/// The least quanta that may stay of a particle: pressure drains it farther than the fabric's own uptake.
Quanta least_rest(const ReferenceState& state, Index i, const std::vector<Quanta>& offer) {
  const std::vector<Index>& list = state.fluid_sample[i];
  for (std::size_t k = 0; k < list.size(); ++k)
    if (offer[k] > 0 && is_permeable(state, list[k])) return state.model.min_quanta / drained_part;
  return state.model.min_quanta;
}

/// o_ij of particle i, in the order of its list of samples.
std::vector<Quanta> offers(const ReferenceState& state, Index i, double dt) {
  const std::vector<Index>& list = state.fluid_sample[i];
  std::vector<double> demands(list.size(), 0.0);
  double sum = 0;
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (!is_porous(state, list[k])) continue;
    demands[k] = demand(state, i, list[k], dt);
    sum += demands[k];
  }
  std::vector<Quanta> offer(list.size(), 0);
  const double mass = fluid_mass(state, i);
  if (!(sum > 0) || !(mass > 0)) return offer;
  const double total = mass * -std::expm1(-sum / mass);  // kg
  Quanta rest = state.s.fluid_mass[i];
  for (std::size_t k = 0; k < list.size(); ++k) {
    offer[k] = floor_quanta(total * demands[k] / sum / state.model.quantum);
    rest -= offer[k];
  }
  // Too little would stay for a particle: it is taken whole.
  const auto largest = std::max_element(offer.begin(), offer.end());
  if (rest > 0 && rest < least_rest(state, i, offer) && *largest > 0) *largest += rest;
  return offer;
}

/// t_ij of particle i from its offers and the samples' φ.
std::vector<Quanta> transfers(const ReferenceState& state, Index i, const std::vector<Quanta>& offer,
                              const std::vector<double>& phi) {
  const std::vector<Index>& list = state.fluid_sample[i];
  std::vector<Quanta> transfer(list.size(), 0);
  bool was_limited = false;
  Quanta rest = state.s.fluid_mass[i];
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (offer[k] == 0) continue;
    transfer[k] = limited(offer[k], phi[list[k]]);
    was_limited = was_limited || phi[list[k]] < 1;
    rest -= transfer[k];
  }
  const Quanta least = least_rest(state, i, offer);
  if (!was_limited || rest <= 0 || rest >= least) return transfer;
  Quanta missing = least - rest;
  for (Quanta& t : transfer) {
    const Quanta cut = std::min(t, missing);
    t -= cut;
    missing -= cut;
  }
  return transfer;
}

/// What goes along with the transfers of particle i; of one that is taken whole, what rounding leaves goes with the
/// largest.
void take_solute(ReferenceState& state, Index i, const std::vector<Quanta>& transfer, std::vector<Quanta>& taken) {
  if (!state.model.has_solute() || transfer.empty()) return;
  const Quanta mass = state.s.fluid_mass[i], carried = state.s.fluid_solute[i];
  Quanta left = carried;
  for (std::size_t k = 0; k < transfer.size(); ++k) {
    const Quanta part = solute_part(carried, transfer[k], mass);
    taken[state.fluid_sample[i][k]] += part;
    left -= part;
  }
  if (std::accumulate(transfer.begin(), transfer.end(), Quanta{0}) == mass && left > 0) {
    taken[state.fluid_sample[i][std::max_element(transfer.begin(), transfer.end()) - transfer.begin()]] += left;
    left = 0;
  }
  state.s.fluid_solute[i] = left;
}

/// Removes what was taken whole, also from the lists of stage porous_neighbors: emission reads them and they name
/// particles by their place in the arrays.
void remove_taken(ReferenceState& state, const std::vector<bool>& gone) {
  remove_particles(state.s, gone);
  std::vector<Index> place(gone.size(), -1);
  Index kept = 0;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (gone[i]) continue;
    state.fluid_sample[kept] = state.fluid_sample[i];
    place[i] = kept++;
  }
  state.fluid_sample.resize(kept);
  for (std::vector<Index>& list : state.sample_fluid) {
    for (Index& i : list) i = place[i];
    std::erase(list, -1);
  }
}

}  // namespace

void absorption(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const Index particles = s.fluid_count(), samples = state.model.samples.count();

  std::vector<std::vector<Quanta>> offer(particles);
  std::vector<Quanta> in(samples, 0);
  for (Index i = 0; i < particles; ++i) {
    offer[i] = offers(state, i, info.dt);
    for (std::size_t k = 0; k < offer[i].size(); ++k) in[state.fluid_sample[i][k]] += offer[i][k];
  }
  const std::vector<Split> split = inflow_split(state, in, state.model.scene.processes.saturation_control);
  std::vector<double> phi;
  phi.reserve(split.size());
  for (const Split& part : split) phi.push_back(part.share);

  std::vector<Quanta> taken(samples, 0), solute(samples, 0);
  std::vector<Momentum> momentum(samples, Momentum{0, 0, 0});
  std::vector<bool> gone(particles, false);
  for (Index i = 0; i < particles; ++i) {
    const std::vector<Quanta> transfer = transfers(state, i, offer[i], phi);
    for (std::size_t k = 0; k < transfer.size(); ++k) {
      const Index j = state.fluid_sample[i][k];
      taken[j] += transfer[k];
      count_on_face(state, j, vec(s.fluid_position[i]), transfer[k], 1);
      add(momentum[j], momentum_of(static_cast<double>(transfer[k]), vec(s.fluid_velocity[i])));
    }
    take_solute(state, i, transfer, solute);
    s.fluid_mass[i] -= std::accumulate(transfer.begin(), transfer.end(), Quanta{0});
    gone[i] = s.fluid_mass[i] == 0;
  }
  give_solute_to_nodes(state, solute, taken, split);
  give_to_nodes(state, taken, momentum, split, info.dt);
  remove_taken(state, gone);
}

}  // namespace drench::reference
