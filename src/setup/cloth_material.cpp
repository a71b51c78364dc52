#include "setup/cloth_material.hpp"

#include <cmath>
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

}  // namespace drench
