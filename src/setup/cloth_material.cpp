#include "setup/cloth_material.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace drench {

ClothMaterial resolve_material(const ClothScene& cloth, const ProcessScene& processes) {
  const MaterialScene& given = cloth.material;
  ClothMaterial m;
  static_cast<BasicMaterial<double>&>(m) = given;
  m.name = cloth.name;
  m.slip = cloth.slip;
  m.dynamics = cloth.dynamics;
  m.self_collision = cloth.self_collision;
  m.friction_wet = given.friction_wet.value_or(given.friction);
  m.damping_wet = given.damping_wet.value_or(given.damping);
  m.emission_cosine = processes.direction ? std::cos(given.emission_angle * std::numbers::pi / 180) : -2;
  if (!processes.emission) m.emission_ramp = 0;
  m.diffusion_exponent = given.diffusion_exponent.value_or(given.diffusion == DiffusionLaw::degenerate ? 1 : 0);
  if (given.weft_diffusivity) m.diffusivity = std::sqrt(given.diffusivity * *given.weft_diffusivity);
  return m;
}

void set_absorption(Model& model) {
  for (std::size_t c = 0; c < model.cloths.size(); ++c) {
    const double uptake = model.scene.cloths[c].material.uptake_velocity;
    ClothMaterial& cloth = model.cloths[c];
    if (uptake > 0)
      cloth.absorption = uptake * model.support * model.support / (7.5 * (1 - cloth.solid_fraction) * cloth.thickness);
  }
}

void set_permeation(Model& model) {
  if (!model.has_fluid() || !(model.scene.fluid.viscosity > 0)) return;
  for (ClothMaterial& cloth : model.cloths) {
    if (!cloth.permeable()) continue;
    cloth.conductance = cloth.permeability / (model.scene.fluid.viscosity * cloth.thickness);
    cloth.entry_potential = cloth.breakthrough_pressure / model.rest_density;
  }
  if (!model.has_permeation()) return;
  for (ClothMaterial& cloth : model.cloths)
    if (cloth.conductance > 0) cloth.emission_velocity = std::numeric_limits<double>::infinity();
}

}  // namespace drench
