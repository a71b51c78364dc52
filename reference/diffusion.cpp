// Stage diffusion of the oracle; the law stands in src/stages/diffusion.hpp.

#include <algorithm>
#include <cmath>

#include "transfer.hpp"

namespace drench::reference {
namespace {

/// Two samples that exchange liquid, first < second.
struct Pair {
  Index first, second;
  double conductance;  // G, kg/s
  double drop;         // (x_first − x_second)·ĝ/ℓ, 1: above 0 if the first is the lower one
};

bool exchange(const ReferenceState& state, Index i, Index j) {
  return is_porous(state, i) && is_porous(state, j) && same_layer(state, i, j);
}

/// κ_ij, 1.
double closeness(const ReferenceState& state, double r) { return 1 - r / state.model.support; }

/// M2_i of every sample, m⁴.
std::vector<double> second_moments(const ReferenceState& state, const Vectors& x) {
  std::vector<double> moment(x.size(), 0.0);
  for (Index i = 0; i < static_cast<Index>(x.size()); ++i) {
    for (const Index j : state.sample_sample[i]) {
      if (!exchange(state, i, j)) continue;
      const double r = (x[i] - x[j]).norm();
      moment[i] += state.model.samples.area[j] * closeness(state, r) * r * r;
    }
  }
  return moment;
}

std::vector<Pair> exchanging_pairs(const ReferenceState& state) {
  const Model& m = state.model;
  const Vectors x = sample_positions(state);
  const std::vector<double> moment = second_moments(state, x);
  const Eigen::Vector3d gravity = vec(m.scene.gravity);
  const Eigen::Vector3d down = gravity.norm() > 0 ? Eigen::Vector3d(gravity.normalized()) : Eigen::Vector3d::Zero();
  std::vector<Pair> pairs;
  for (Index i = 0; i < m.samples.count(); ++i) {
    for (const Index j : state.sample_sample[i]) {
      if (j < i || !exchange(state, i, j)) continue;
      const ClothMaterial& cloth = m.cloths[m.samples.cloth[i]];
      const double mean = 0.5 * (moment[i] + moment[j]);
      if (mean == 0) continue;
      const auto& c = m.samples.capacity;
      const auto& a = m.samples.area;
      const double conductance =
          4 * cloth.diffusivity * 0.5 * (c[i] * a[j] + c[j] * a[i]) * closeness(state, (x[i] - x[j]).norm()) / mean;
      pairs.push_back({i, j, conductance, (x[i] - x[j]).dot(down) / cloth.capillary_height});
    }
  }
  return pairs;
}

int substeps(const ReferenceState& state, const std::vector<Pair>& pairs, double dt) {
  std::vector<double> rate(state.model.samples.count(), 0.0);  // C_i rate_i, kg/s
  for (const Pair& pair : pairs) {
    rate[pair.first] += pair.conductance * (1 + std::abs(pair.drop));
    rate[pair.second] += pair.conductance * (1 + std::abs(pair.drop));
  }
  double fastest = 0;
  for (Index p = 0; p < state.model.samples.count(); ++p) {
    if (state.model.samples.capacity[p] > 0) fastest = std::max(fastest, rate[p] / state.model.samples.capacity[p]);
  }
  return std::max(1, static_cast<int>(std::ceil(dt * fastest / 0.5)));
}

/// F, kg/s: the flux from the second sample to the first.
double flux(const ReferenceState& state, const Pair& pair, const std::vector<double>& saturation) {
  const double first = saturation[pair.first], second = saturation[pair.second];
  double spread = 1, upstream = 1;
  if (state.model.cloths[state.model.samples.cloth[pair.first]].diffusion == DiffusionLaw::degenerate) {
    spread = 0.5 * (first + second);
    upstream = pair.drop > 0 ? second : first;
  }
  return pair.conductance * (spread * (second - first) + upstream * pair.drop);
}

/// φ^out of every sample, 1: which part of `out` its nodes can give without falling below 0.
std::vector<double> outflow_limit(const ReferenceState& state, const std::vector<Quanta>& out) {
  const std::vector<Quanta> outflow = gather_at_nodes(state, out);
  std::vector<double> phi(state.s.node_count(), 1.0);
  for (Index n = 0; n < state.s.node_count(); ++n) {
    const Quanta have = std::max<Quanta>(0, state.s.node_liquid[n] - (outflow[n] >> 16) - 1024);
    if (outflow[n] > have) phi[n] = static_cast<double>(have) / static_cast<double>(outflow[n]);
  }
  return least_over_nodes(state, phi);
}

/// One of n sub-steps of the step dt.
void exchange_once(ReferenceState& state, const std::vector<Pair>& pairs, double dt, int n) {
  const Index samples = state.model.samples.count();
  std::vector<double> saturation(samples);
  for (Index p = 0; p < samples; ++p) saturation[p] = sample_saturation(state, p);

  std::vector<Quanta> offer(pairs.size());
  std::vector<bool> to_first(pairs.size());
  std::vector<Quanta> out(samples, 0), in(samples, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double f = flux(state, pairs[k], saturation);
    to_first[k] = f > 0;
    offer[k] = floor_quanta(std::abs(f) * dt / (n * state.model.quantum));
    out[to_first[k] ? pairs[k].second : pairs[k].first] += offer[k];
    in[to_first[k] ? pairs[k].first : pairs[k].second] += offer[k];
  }

  const std::vector<double> phi_out = outflow_limit(state, out);
  const std::vector<double> phi_in = inflow_limit(state, in);
  std::vector<Quanta> change(samples, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Index donor = to_first[k] ? pairs[k].second : pairs[k].first;
    const Index receiver = to_first[k] ? pairs[k].first : pairs[k].second;
    const Quanta moved = limited(offer[k], std::min(phi_out[donor], phi_in[receiver]));
    change[donor] -= moved;
    change[receiver] += moved;
  }
  for (Index p = 0; p < samples; ++p) {
    const std::array<Quanta, 3> part = split_over_nodes(state.model.samples.weight[p], std::abs(change[p]));
    for (int k = 0; k < 3; ++k) {
      state.s.node_liquid[sample_node(state, p, k)] += change[p] < 0 ? -part[k] : part[k];
    }
  }
}

}  // namespace

void diffusion(ReferenceState& state, const StepInfo& info, StepReport& report) {
  const std::vector<Pair> pairs = exchanging_pairs(state);
  const int n = substeps(state, pairs, info.dt);
  for (int k = 0; k < n; ++k) exchange_once(state, pairs, info.dt, n);
  report.diffusion_substeps = n;
}

}  // namespace drench::reference
