#pragma once
// Stage jets: lets particles go from the nozzles, one by one.
//
// Law:    docs/theory/liquid.md, Where liquid comes from (Eqs. 28 to 29f, 29h); docs/theory/keys.md, Jets.
// Reads:  Model::jets, time (s), jet_particles.
// Writes: fluid_* (appended with ids in order, age 0, Origin::jet or mouth, Jet::mass), next_id, jet_particles,
//         supplied (quanta).
// Solute: goes along with its liquid (docs/theory/solute.md): fluid_solute, solute_supplied (quanta).
// Errors: none.

namespace drench {

/// s: over which the density solve begins to see liquid from emitters whose points or paths lie in no lattice
/// (docs/theory/liquid.md, Eq. 25).
inline constexpr double mouth_ramp = 0.02;

}  // namespace drench
