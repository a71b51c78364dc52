#pragma once
// A cloth's material as the stages use it.

#include "state/model.hpp"

namespace drench {

/// The numbers of a fabric of the scene's cloth, with what follows from them: wet friction and damping, the cone of
/// emission, what a process that is off leaves out. `absorption` follows later from `uptake_velocity`, with the support
/// radius (set_absorption).
ClothMaterial resolve_material(const ClothScene& cloth, const MaterialScene& fabric, const ProcessScene& processes);

/// k_a = u_a h² / (7.5 (1−Φ) τ) in the cloths that have an uptake velocity u_a; h is the model's support.
void set_absorption(Model& model);

/// β, 1/m: the coefficient of quadratic drag across the fabric, given or by Ergun's equation (docs/theory/porous.md,
/// Eq. 29a).
double inertial_drag(const BasicMaterial<double>& fabric);

/// The conductance k/(ν τ) and the entry potential p_b/ρ0 of the cloths that liquid passes through, whose excess leaves
/// at once unless they carry a film.
void set_permeation(Model& model);

/// How films of liquid run and drip on the cloths that have them, and how much they hold (docs/theory/porous.md).
void set_films(Model& model);

}  // namespace drench
