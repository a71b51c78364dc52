#pragma once
// Films of liquid on soaked cloth (docs/theory/porous.md, section 16): what set-up, backends and the reference share.

#include <algorithm>
#include <cmath>

#include "state/model.hpp"

namespace drench {

inline constexpr double water_surface_tension = 0.072;  // N/m

/// σ, N/m, of the scene, or that of water where it has none.
inline double film_tension(const Model& model) {
  const double own = model.scene.fluid.surface_tension;
  return own > 0 ? own : water_surface_tension;
}

/// The saturation that node n never exceeds, 1. At a hem the film gathers to drops that hang: up to the capillary
/// length √(σ/(ρ0 |g|)).
inline double ceiling_of_node(const Model& model, Index n) {
  const ClothMaterial& m = model.material_of_node(n);
  const Vec3& g = model.scene.gravity;
  const double gravity = std::hypot(g[0], g[1], g[2]);
  const bool drips = m.film_depth > 0 && gravity > 0 && !model.fabric.hem.empty();
  if (!drips || !model.fabric.hem[static_cast<std::size_t>(n)]) return m.max_saturation;
  const double drop = std::sqrt(film_tension(model) / (model.rest_density * gravity));
  return std::max(m.max_saturation, 1 + drop / m.film_depth);
}

}  // namespace drench
