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

/// A particle's load on the sheets near it, m⁵/s²: as dense as its image there, V_i κ_i.
KOKKOS_INLINE_FUNCTION Real sheet_load(Real ratio, Real volume, Real kappa) {
  return image_density(ratio) * volume * kappa;
}

/// Particles with α = 0 carry no pressure: their κ of the density solve becomes 0. The others' load on sheets goes to
/// work.predicted.
void warm_start_density(Fluid& fluid, const Cloth& cloth, PressureWork& work);
/// nodes.force = f_n, N, of the loads in work.predicted.
void load_cloth(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const PressureWork& work,
                Cloth& cloth);
/// Nodes with their inertia alone: nodes.acceleration = a_n, samples.predicted = v_b + Δt a_b.
void predict_free_cloth(Cloth& cloth, Real dt);
/// v_n += Δt a_n, pin_force −= f_n on pinned nodes.
void accept_free_cloth(Cloth& cloth, Real dt);

}  // namespace drench::kokkos_backend
