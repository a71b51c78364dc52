#pragma once
// Stage ledger: the account of every quantum, and of what is finite (physics.md section 1).
//
// Law.  mass_fluid = Σ_i m_i, mass_cloth = Σ_n m_n: exact integer sums. total = fluid + cloth + drained − supplied is
// constant, exactly.
//       mass_float (kg): compensated (Neumaier) sum of the floating-point masses, as an independent check of the
//       ledger. saturation_max = max_n m_n/C_n over nodes with C_n > 0. kinetic_energy = ½ Σ m v² (J; liquid, and cloth
//       nodes with m_s + m_f), double. nonfinite = number of particles, nodes and bodies with a NaN or infinity in position or
//       velocity. fluid_speed = max_i |v_i|, cloth_speed = max_n |v_n| (m/s), cloth_stretch = max over the edges of cloth that
//       moves of length over length at rest (1): what pipeline/failure.hpp holds against its bounds. particles = number of liquid particles.
// Reads:  everything.   Writes: StepReport.
