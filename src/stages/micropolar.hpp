#pragma once
// Stage micropolar: every liquid particle has a spin of its own, which drives the flow and is driven by it (Bender,
// Koschier, Kugelstadt & Weiler 2017, 2019).
//
// Law:    docs/theory/micropolar.md: continuum (Eq. 1), sums (2 to 4), balances (5 to 7), stages of RKL1 (8).
// Reads:  fluid_position (m), fluid_mass (quanta), list fluid→fluid, fluid_velocity (m/s), fluid_spin (1/s); the
//         scene's `fluid.micropolar`: transfer, viscosity (m²/s), inertia (Θ/d², 1), reaction (1).
// Writes: fluid_velocity (m/s), fluid_spin (1/s); StepReport::micropolar_stages.
// Errors: none. There is no limit on Δt.
