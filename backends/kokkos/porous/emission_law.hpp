#pragma once
// How cloth gives back what it holds above capacity: paper Eqs. 9–10 in the form of src/stages/emission.hpp.

#include "core/types.hpp"

namespace drench::kokkos_backend::laws {

/// The part of the excess beyond the buffered that matures in a step, 1: 1 − exp(−u_e Δt/d), u_e in m/s (paper
/// section 3.4, rate limit).
KOKKOS_INLINE_FUNCTION double maturing(double emission_velocity, double dt, double spacing) {
  return -Kokkos::expm1(-emission_velocity * dt / spacing);
}

/// Stands for the pull on a film at a hem, which drips there as fast as liquid leaves.
inline constexpr Real at_hem = -1;

/// u_e of fabric with a film, m/s: a film of thickness h (m) that hangs under a face drips at the rate of the
/// Rayleigh–Taylor instability (docs/theory/porous.md, Eq. 41), but no faster than `fastest`. `pull`: square of
/// gravity's component normal to the face, m²/s⁴.
KOKKOS_INLINE_FUNCTION double film_velocity(double fastest, double growth, Real pull, double h, double spacing) {
  return pull == at_hem ? fastest : smaller(fastest, growth * double(pull) * h * h * h * spacing);
}

/// E_pk, quanta: the share of sample p in the buffered liquid of its node k, floor(w_pk m^b_k/w′_k) (Eq. 9).
KOKKOS_INLINE_FUNCTION Quanta buffered_share(double weight, Quanta buffered, double weight_sum) {
  return weight > 0 && weight_sum > 0 && buffered > 0
             ? static_cast<Quanta>(Kokkos::floor(weight * double(buffered) / weight_sum))
             : 0;
}

/// What liquid of room R_j (quanta) accepts of one offer when all offers to it sum to O_j: never more than R_j in all.
KOKKOS_INLINE_FUNCTION Quanta accepted_offer(Quanta offer, Quanta all_offers, Quanta room) {
  if (all_offers <= room) return offer;
  return static_cast<Quanta>(Kokkos::floor(double(offer) * (double(room) / double(all_offers)) * (1 - 1e-9)));
}

/// cos 30°: fabric that lies ahead within this cone is steeper than 60°.
inline constexpr Real ahead_cosine = Real(0.8660254037844386);

/// Does a sample of another layer, this far from the one that emits (m), leave no room for a new particle? It lies
/// within 3 d/2 along the way out and 3 d/4 beside it.
KOKKOS_INLINE_FUNCTION bool shuts_in(const Real3& apart, const Real3& flow, Real spacing) {
  const Real size = norm(flow);
  if (!(size > 0)) return false;
  const Real ahead = dot(apart, flow) / size;
  const Real3 beside = apart - (ahead / size) * flow;
  return ahead > 0 && ahead < Real(1.5) * spacing && dot(beside, beside) < Real(0.5625) * spacing * spacing;
}

/// Σ_j V_j W at a plane surface of the liquid, 1; where it is more a place lies inside.
inline constexpr double surface_share = 0.5;
/// What a particle that is too close adds to that sum: more than any liquid has.
inline constexpr double crowded_share = 16;

/// Distance from a sample at which its new particle appears, m: r_p + r_new = (d/2)(1 + cbrt(m/m0)).
KOKKOS_INLINE_FUNCTION Real emission_distance(Real spacing, double mass_fraction) {
  return spacing / 2 * (1 + Real(Kokkos::cbrt(mass_fraction)));
}

}  // namespace drench::kokkos_backend::laws
