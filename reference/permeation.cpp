// Stage permeation of the oracle; the law stands in src/stages/permeation.hpp.

#include <algorithm>

#include "transfer.hpp"

namespace drench::reference {
namespace {

/// The potential of the liquid on one side of a sample, from what is there.
struct Side {
  double filled = 0, sum = 0;  // Σ V W, 1; Σ V W φ, m²/s²

  double potential(double in_air) const {
    return (sum + std::max(0.0, full_side - filled) * in_air) / std::max(filled, full_side);
  }
};

/// Both sides of sample p: [0] against its normal, [1] along it.
std::array<Side, 2> sides_of(const ReferenceState& state, Index p) {
  const Smoothing smoothing(state.model);
  const Eigen::Vector3d x = sample_position(state, p), n = sample_normal(state, p), g = vec(state.model.scene.gravity);
  std::array<Side, 2> sides;
  for (const Index i : state.sample_fluid[p]) {
    const Eigen::Vector3d away = vec(state.s.fluid_position[i]) - x;
    const double weight = fluid_volume(state, i) * smoothing.value(away.norm());
    const double kappa = state.s.fluid_kappa_density[i] + state.s.fluid_kappa_divergence[i];
    Side& side = sides[away.dot(n) >= 0 ? 1 : 0];
    side.filled += weight;
    side.sum += weight * std::max(0.0, kappa - g.dot(away));
  }
  return sides;
}

}  // namespace

void permeation(ReferenceState& state, const StepInfo&, StepReport&) {
  const Model& m = state.model;
  const Eigen::Vector3d g = vec(m.scene.gravity);
  state.sample_supply.assign(m.samples.count(), 0.0);
  for (Index p = 0; p < m.samples.count(); ++p) {
    state.s.sample_flux[p] = 0;
    const ClothMaterial& cloth = m.cloths[m.samples.cloth[p]];
    if (!(cloth.conductance > 0)) continue;
    const std::array<Side, 2> sides = sides_of(state, p);
    const Eigen::Vector3d n = sample_normal(state, p);
    const double air = 0.5 * cloth.thickness * g.dot(n);  // of the side that the normal leaves
    const double drive = sides[0].potential(air) - sides[1].potential(-air);
    const Side& upstream = sides[drive > 0 ? 0 : 1];
    const bool open = std::fabs(drive) > cloth.entry_potential && upstream.filled > 0;
    if (open) {
      state.s.sample_flux[p] = cloth.conductance * drive;
      state.s.sample_flow_direction[p] = arr((drive > 0 ? 1 : -1) / 1.001 * n);
      state.sample_supply[p] = std::max(upstream.filled, full_side);
    } else if (sides[0].filled > covered_side && sides[1].filled > covered_side) {
      state.s.sample_flow_direction[p] = {0, 0, 0};
    }
  }
}

}  // namespace drench::reference
