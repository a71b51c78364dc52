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
/// A pressure on the sheets: κ, with that of ghosts, and λ, null without. The ghosts' λ are fetched.
struct SheetLoad {
  const SheetRows& rows;
  const Exchange& exchange;
  const Field<Real>& pressure;
  Field<Real>* contact_pressure = nullptr;
};
/// nodes.force = f_n = Σ_i ρ0 V_i (κ_i + λ_i) p_in, N.
void load_cloth(const SheetLoad& load, Cloth& cloth);
/// The same, with what nodes with their inertia alone answer: nodes.predicted = v_n + Δt a_n.
void load_free_cloth(const SheetLoad& load, Cloth& cloth, Real dt);
/// What an elastic cloth takes from its loads: the targets of free nodes, base + Δt² f_n/m_n, m.
struct NodeTargets {
  Entries<Real3> target;
  Entries<const Real3> base;
  Entries<const Real> mass;
  Entries<const std::uint8_t> pinned;
  Real dt;

  KOKKOS_INLINE_FUNCTION void operator()(Index n, const Real3& f) const {
    if (!pinned(n)) target(n) = base(n) + (dt * dt / mass(n)) * f;
  }
};
void load_elastic_cloth(const SheetLoad& load, Cloth& cloth, const NodeTargets& targets);
/// v_n = nodes.predicted, pin_force −= f_n on fixed nodes.
void accept_free_cloth(Cloth& cloth);

}  // namespace drench::kokkos_backend
