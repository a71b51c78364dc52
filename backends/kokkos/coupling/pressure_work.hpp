#pragma once
// Arrays of the pressure solves (stages divergence and pressure); scratch between stages.

#include <memory>

#include "bodies/rigid.hpp"
#include "particles/fluid.hpp"

namespace drench::kokkos_backend {

struct PressureWork {
  Field<Real4> position_kappa;         // x_i, m, and κ_i, m²/s²: one load for the pairs
  Field<Real4> predicted;              // v_i + Δt a_i, m/s, and κ_i: one load for the pairs
  Field<Real> free_rate;               // Dδ_i/Dt, 1/s, without any pressure; only where solves start scaled
  Field<Real> density_rate;            // Dδ_i/Dt, 1/s, of the predicted velocities, less what yields
  Field<Real> next_kappa, last_kappa;  // the iterates beside κ, m²/s²
  Field<std::uint8_t> active;          // takes part in the divergence solve
  Field<Real> contact_pressure;        // λ_i, m²/s²; these four only where liquid can touch sheets
  Field<Real> next_contact_pressure, last_contact_pressure;
  Field<Real> approach_rate;   // R'_i, 1/s
  Field<Wrench> bodies_ahead;  // a body: the impulses of a solve's start (coupling/wall_push.hpp), kg m/s and kg m²/s
  // of the lean iterations (fluid/lean_pressure.hpp)
  Field<Real> liquid_rate;                          // the liquid's part of Dδ_i/Dt, 1/s
  Field<Real> other_kappa, other_contact_pressure;  // of the next iteration, m²/s²
  std::shared_ptr<struct LeanPressure> lean;
};

inline void allocate_pressure_work(PressureWork& work, const Fluid& fluid) {
  const std::size_t n = fluid.particles.capacity();
  make_room(work.position_kappa, "drench::pressure::position_kappa", n);
  make_room(work.predicted, "drench::pressure::predicted", n);
  make_room(work.density_rate, "drench::pressure::density_rate", n);
  make_room(work.next_kappa, "drench::pressure::next_kappa", n);
  make_room(work.last_kappa, "drench::pressure::last_kappa", n);
}

/// A particle's, of allocate_pressure_work.
inline double pressure_work_bytes(const Sizing& s) {
  const bool scaled = (s.size.samples == 0 && s.size.dynamic_samples == 0) ||
                      s.size.scene.fluid.solver.source_error.has_value();  // free_rate
  return (scaled ? 12 : 11) * s.real;
}

}  // namespace drench::kokkos_backend
