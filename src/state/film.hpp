#pragma once
// How much liquid a node of cloth that carries a film may hold (docs/theory/porous.md, section 16).

#include <algorithm>
#include <cmath>

#include "state/model.hpp"

namespace drench {

/// The saturation that node n never exceeds, 1. At a hem the film gathers to drops that hang: up to the capillary
/// length √(σ/(ρ0 |g|)).
inline double ceiling_of_node(const Model& model, Index n) {
  const ClothMaterial& m = model.material_of_node(n);
  const auto at = static_cast<std::size_t>(n);
  if (!(m.film_flow > 0) || model.fabric.hem.empty() || !model.fabric.hem[at]) return m.max_saturation;
  // film_flow/film_growth = σ |g|
  const double gravity = std::hypot(model.scene.gravity[0], model.scene.gravity[1], model.scene.gravity[2]);
  const double tension = m.film_flow / (m.film_growth * gravity);
  const double drop = std::sqrt(tension / (model.rest_density * gravity));
  return std::max(m.max_saturation, 1 + drop / m.film_depth);
}

}  // namespace drench
