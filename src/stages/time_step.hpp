#pragma once
// Stage time_step: chooses Δt, and resets what the step accumulates.
//
// Law.  mode fixed: Δt = time.step.
//       mode cfl:   Δt = min(time.step, λ d / v_max), but at least time.step / 1000 (Courant number λ = time.cfl,
//       v_max = the largest speed of liquid particles, cloth nodes and moving bodies (bodies.hpp, law 7); a particle's speed counts
//       what gravity adds in one maximal step, and the scene's field (forces.hpp): |v| + |g − Ω² (x − c)| · time.step). Source: Courant,
//       Friedrichs & Lewy 1928; Monaghan 1992. Unit: s.
//       With surface tension or adhesion also Δt ≤ 0.7 √(ρ0 d³/(2π s)), the period of the shortest capillary waves
//       (Brackbill, Kothe & Zemach 1992), s = the largest of σ and all `adhesion` (N/m). Drops with h = 2 d are right up
//       to 0.84 of that root; at 1.05 of it ω² is 0.62 of Rayleigh's and at 1.26 they burst. In mode fixed a larger step
//       is warned of.
//       The pipeline may shorten Δt to land on an output time.
//       Viscosity does not limit Δt (forces.hpp).
// The choice comes first in the step, not after the non-pressure forces, so that the divergence solve, the density
// solve and the advection all use the same Δt.
// Reads:  fluid_velocity, fluid_position (with a field), node_velocity.   Writes: StepReport::dt_wanted; node_pin_force := 0.
