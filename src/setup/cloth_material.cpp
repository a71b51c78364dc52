#include "setup/cloth_material.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "state/film.hpp"

namespace drench {

ClothMaterial resolve_material(const ClothScene& cloth, const MaterialScene& given, const ProcessScene& processes) {
  ClothMaterial m;
  static_cast<BasicMaterial<double>&>(m) = given;
  m.name = cloth.name;
  m.slip = cloth.slip;
  m.areal_density = given.areal_density;
  m.compression_per_mass = given.compression / given.areal_density;
  m.rigid_share = given.squeezes() ? 1 - given.compressibility : 0;
  m.uptake_velocity = given.uptake_velocity;
  m.most_saturation = cloth.material.ceiling();
  for (const RegionScene& region : cloth.regions)
    m.most_saturation = std::max(m.most_saturation, region.material.ceiling());
  m.dynamics = cloth.dynamics;
  m.self_collision = cloth.self_collision;
  m.friction_wet = given.friction_wet.value_or(given.friction);
  m.damping_wet = given.damping_wet.value_or(given.damping);
  m.emission_cosine = processes.direction ? std::cos(given.emission_angle * std::numbers::pi / 180) : -2;
  if (!processes.emission) m.emission_ramp = 0;
  m.diffusion_exponent = given.exponent();
  if (given.weft_diffusivity) m.diffusivity = std::sqrt(given.diffusivity * *given.weft_diffusivity);
  return m;
}

void set_absorption(Model& model) {
  for (auto* list : {&model.cloths, &model.patches})
    for (ClothMaterial& m : *list)
      if (m.uptake_velocity > 0)
        m.absorption = m.uptake_velocity * model.support * model.support / (7.5 * (1 - m.solid_fraction) * m.thickness);
}

double inertial_drag(const BasicMaterial<double>& m) {
  const double open = 1 - m.solid_fraction, sphere = 1.5 * m.fibre_diameter;  // of the same surface per volume
  const double ergun = m.fibre_diameter > 0 ? 1.75 * m.solid_fraction / (open * open * open * sphere) : 0;
  return m.forchheimer > 0 ? m.forchheimer : ergun;
}

void set_permeation(Model& model) {
  if (!model.has_fluid() || !(model.scene.fluid.viscosity > 0)) return;
  for (auto* list : {&model.cloths, &model.patches})
    for (ClothMaterial& m : *list) {
      if (!m.permeable()) continue;
      m.conductance = m.permeability / (model.scene.fluid.viscosity * m.thickness);
      m.inertial_loss = inertial_drag(m) * m.thickness;
      m.entry_potential = m.breakthrough_pressure / model.rest_density;
    }
  if (!model.has_permeation()) return;
  for (auto* list : {&model.cloths, &model.patches})
    for (ClothMaterial& m : *list)
      if (m.conductance > 0 && !m.has_film()) m.emission_velocity = std::numeric_limits<double>::infinity();
}

void set_films(Model& model) {
  if (model.has_baked_liquid()) return;  // nothing would run down or drip
  const FluidScene& fluid = model.scene.fluid;
  const double g = std::hypot(model.scene.gravity[0], model.scene.gravity[1], model.scene.gravity[2]);
  for (auto* list : {&model.cloths, &model.patches})
    for (ClothMaterial& m : *list) {
      if (!m.has_film()) continue;
      m.film_depth = (1 - m.solid_fraction) * m.thickness;
      m.max_saturation = m.ceiling();
      if (!fluid.present) continue;
      const double viscosity = m.film_viscosity > 0 ? m.film_viscosity : fluid.viscosity;
      m.film_flow = model.rest_density * g / (12 * viscosity);
      m.film_growth = model.rest_density / (12 * viscosity * film_tension(model));
    }
}

}  // namespace drench
