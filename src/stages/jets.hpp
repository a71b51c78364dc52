#pragma once
// Stage jets: lets particles go from the nozzles, one by one.
//
// Law.  A jet of radius R and speed |v| carries ρ0 π R² |v| kg/s. Particle q = 0, 1, … leaves at
//       t_q = start + (q + ½) interval,  interval = d³/(π R² |v|) (s),
//       so that the mass let go never differs from ρ0 π R² |v| (t − start) by more than half a particle. Its place in the
//       mouth is offset[q mod n]; the n offsets are ordered along one axis of their lattice, so that the layers, n interval
//       |v| ≥ d apart, are planes tilted by that much over the diameter, and no two particles are closer than d.
//       In a step that ends at t' = time + Δt every particle with t_q ≤ t' and t_q < end that has not left yet is created
//       at centre + offset + v (t' − t_q), velocity v, mass m0, age 0, Origin::jet, ids in order; `supplied` grows by the
//       mass created.
// Reads:  Model::jets, time.   Writes: fluid_* (appended), next_id, jet_particles, supplied.
