#pragma once
// What the pressure of the liquid does to the sheets, and how nodes answer that have nothing but their inertia.
// Laws: docs/theory/walls_and_sheets.md.

#include "cloth/cloth.hpp"
#include "coupling/pressure_work.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {

/// Does the density solve have contact with sheets?
inline bool has_sheet_contact(const Constants& constants, const Cloth& cloth) {
  return cloth.samples.count > 0 && !constants.model.scene.through_cloth;
}

/// Particles with α = 0 carry no pressure: their κ of the density solve becomes 0.
void warm_start_density(Fluid& fluid, PressureWork& work);
/// nodes.force = f_n = Σ_i ρ0 V_i (κ_i + λ_i) p_in, N. `contact_pressure`: null without λ.
void load_cloth(const SheetRows& rows, const Field<Real>& pressure, const Field<Real>* contact_pressure, Cloth& cloth);
/// Nodes with their inertia alone: nodes.predicted = v_n + Δt a_n.
void predict_free_cloth(Cloth& cloth, Real dt);
/// v_n = nodes.predicted, pin_force −= f_n on pinned nodes.
void accept_free_cloth(Cloth& cloth);

}  // namespace drench::kokkos_backend
