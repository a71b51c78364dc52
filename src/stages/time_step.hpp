#pragma once
// Stage time_step: chooses Δt, and resets what the step accumulates.
//
// Law.  mode fixed: Δt = time.step.
//       mode cfl:   Δt = min(time.step, λ d / v_max), but at least time.step / 1000 (Courant number λ = time.cfl,
//       v_max = the largest speed of liquid particles, cloth nodes and moving bodies (bodies.hpp, law 7); a particle's speed counts what gravity adds in
//       one maximal step: |v| + |g| · time.step). Source: Courant, Friedrichs & Lewy 1928; Monaghan 1992. Unit: s.
//       The pipeline may shorten Δt to land on an output time.
// The choice comes first in the step, not after the non-pressure forces, so that the divergence solve, the density
// solve and the advection all use the same Δt.
// Reads:  fluid_velocity, node_velocity.   Writes: StepReport::dt_wanted; node_pin_force := 0.
