// Stage permeation of the oracle; the law stands in src/stages/permeation.hpp.

#include <algorithm>

#include "transfer.hpp"

namespace drench::reference {
namespace {

/// What sample p feels of the liquid around it.
struct Surroundings {
  std::array<double, 2> filled{0, 0};  // Σ V W on the side that the normal leaves and on the other one, 1
  double load = 0;                     // the liquid's pressure on it along the normal, over ρ0, m²/s²
};

Surroundings around(const ReferenceState& state, Index p) {
  const Smoothing smoothing(state.model);
  const Eigen::Vector3d x = sample_position(state, p), n = sample_normal(state, p);
  Surroundings result;
  for (const Index i : state.sample_fluid[p]) {
    const Eigen::Vector3d away = vec(state.s.fluid_position[i]) - x;
    result.filled[away.dot(n) >= 0 ? 1 : 0] += fluid_volume(state, i) * smoothing.value(away.norm());
    const double kappa = state.s.fluid_kappa_density[i] + state.s.fluid_kappa_divergence[i];
    result.load += wall_share * image_density(state.s.fluid_density_ratio[i]) * fluid_volume(state, i) * state.s.sample_volume[p] *
                   kappa * smoothing.gradient(from_behind(state, i, p)).dot(n);
  }
  result.load /= state.model.samples.area[p];
  return result;
}

/// How much of a side counts as air, 1.
double air_share(double filled) { return std::max(0.0, 1 - filled / full_side); }

}  // namespace

void permeation(ReferenceState& state, const StepInfo&, StepReport&) {
  const Model& m = state.model;
  const Eigen::Vector3d g = vec(m.scene.gravity);
  state.sample_supply.assign(m.samples.count(), 0.0);
  for (Index p = 0; p < m.samples.count(); ++p) {
    state.s.sample_flux[p] = 0;
    const ClothMaterial& cloth = m.cloths[m.samples.cloth[p]];
    if (!(cloth.conductance > 0)) continue;
    const Surroundings liquid = around(state, p);
    const Eigen::Vector3d n = sample_normal(state, p);
    const double air = 0.5 * cloth.thickness * g.dot(n) * (air_share(liquid.filled[0]) + air_share(liquid.filled[1]));
    const double drive = liquid.load + air, upstream = liquid.filled[drive > 0 ? 0 : 1];
    const bool open = std::fabs(drive) > cloth.entry_potential && upstream > 0;
    if (open) {
      state.s.sample_flux[p] = cloth.conductance * drive;
      state.s.sample_flow_direction[p] = arr((drive > 0 ? 1 : -1) / 1.001 * n);
      state.sample_supply[p] = std::max(upstream, full_side);
    } else if (liquid.filled[0] > covered_side && liquid.filled[1] > covered_side) {
      state.s.sample_flow_direction[p] = {0, 0, 0};
    }
  }
}

}  // namespace drench::reference
