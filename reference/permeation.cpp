// Stage permeation of the oracle; the law stands in src/stages/permeation.hpp.

#include <algorithm>

#include "transfer.hpp"

namespace drench::reference {
namespace {

/// What sample p feels of the liquid around it.
struct Surroundings {
  std::array<double, 2> filled{0, 0};     // Σ V W on the side that the normal leaves and on the other one, 1
  std::array<double, 2> potential{0, 0};  // Σ V W φ there, m²/s²
  double load = 0;                        // the liquid's pressure on it along the normal, over ρ0, m²/s²
  double at_walls = 0;                    // how close extrapolated walls are, 0 to 1
};

/// How much of a side counts as air, 1.
double air_share(double filled) { return std::max(0.0, 1 - filled / full_side); }

Surroundings around(const ReferenceState& state, Index p) {
  const Smoothing smoothing(state.model);
  const Eigen::Vector3d x = sample_position(state, p), n = sample_normal(state, p);
  Surroundings result;
  for (const Index i : state.sample_fluid[p]) {
    const Eigen::Vector3d away = vec(state.s.fluid_position[i]) - x;
    const double kappa = state.s.fluid_kappa_density[i] + state.s.fluid_kappa_divergence[i];
    const double weight = fluid_volume(state, i) * smoothing.value(away.norm());
    const int side = away.dot(n) >= 0 ? 1 : 0;
    result.filled[side] += weight;
    result.potential[side] += weight * std::max(0.0, kappa - vec(state.model.scene.gravity).dot(away));
    result.load += wall_share * image_density(state.s.fluid_density_ratio[i]) * fluid_volume(state, i) *
                   state.s.sample_volume[p] * kappa * smoothing.gradient(from_behind(state, i, p)).dot(n);
  }
  result.load /= state.model.samples.area[p];
  double walls = 0;
  if (state.model.extrapolates_walls())
    for (const Index b : state.sample_boundary[p])
      walls += state.s.boundary_volume[b] * smoothing.value((x - vec(state.s.boundary_position[b])).norm());
  result.at_walls = 1 - air_share(walls);
  return result;
}

/// How far both sides are covered, 0 to 1.
double covered_share(const Surroundings& liquid) {
  const double less = std::min(liquid.filled[0], liquid.filled[1]);
  return std::clamp((less - full_side) / (covered_side - full_side), 0.0, 1.0);
}

/// The mean potential of a side as far as it is liquid, m²/s².
double mean_potential(const Surroundings& liquid, int side) {
  if (liquid.filled[side] == 0) return 0;
  return (1 - air_share(liquid.filled[side])) * liquid.potential[side] / liquid.filled[side];
}

/// What drives liquid along the normal, m²/s²: the load where one side is free, the difference of potentials where both
/// are covered or walls carry a part of the load.
double drive_of(const Surroundings& liquid, double half_thickness) {
  const double by_pressure = std::max(covered_share(liquid), liquid.at_walls);
  return (1 - by_pressure) * liquid.load + by_pressure * (mean_potential(liquid, 0) - mean_potential(liquid, 1)) +
         half_thickness * (air_share(liquid.filled[0]) + air_share(liquid.filled[1]));
}

/// What of a flux a difference of potentials drives that is less by `unresolved` (m²/s²).
double beyond(const ClothMaterial& cloth, double flux, double unresolved) {
  const double u = std::fabs(flux), drive = u / cloth.conductance + cloth.inertial_loss * u * u;
  return std::copysign(flux_through(cloth, std::max(0.0, drive - unresolved)), flux);
}

}  // namespace

void permeation(ReferenceState& state, const StepInfo& info, StepReport&) {
  const Model& m = state.model;
  const Eigen::Vector3d g = vec(m.scene.gravity);
  state.sample_supply.assign(m.samples.count(), 0.0);
  state.sample_passing.assign(m.samples.count(), 0.0);
  for (Index p = 0; p < m.samples.count(); ++p) {
    const ClothMaterial& cloth = m.material_of_sample(p);
    if (!(cloth.conductance > 0)) continue;
    const Surroundings liquid = around(state, p);
    const Eigen::Vector3d n = sample_normal(state, p);
    const double now = flux_through(cloth, drive_of(liquid, 0.5 * cloth.thickness * g.dot(n)));
    double& flux = state.s.sample_flux[p];
    flux += info.dt / (info.dt + cloth.emission_ramp) * (now - flux);
    const double upstream = liquid.filled[flux > 0 ? 0 : 1];
    if (upstream == 0) flux = 0;
    state.sample_passing[p] = beyond(cloth, flux, covered_share(liquid) * m.spacing * g.norm());
    if (is_driven(state, p)) {
      state.s.sample_flow_direction[p] = arr((flux > 0 ? 1 : -1) / 1.001 * n);
      state.sample_supply[p] = std::max(upstream, full_side);
    } else if (liquid.filled[0] > covered_side && liquid.filled[1] > covered_side) {
      state.s.sample_flow_direction[p] = {0, 0, 0};
    }
  }
}

}  // namespace drench::reference
