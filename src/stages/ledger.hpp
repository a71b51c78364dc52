#pragma once
// Stage ledger: the account of every quantum, and of what is finite, fast or stretched.
//
// Law:    docs/theory/mass.md: quanta (Eqs. 1, 2), the ledger (3), the other sums of the stage (table).
// Reads:  everything.
// Writes: StepReport: mass_* (quanta), mass_float (kg), saturation_max (1), kinetic_energy (J), nonfinite, particles,
//         fluid_speed, cloth_speed (m/s), cloth_stretch (1), tunnelled; solute_* (quanta) where there is a solute.
// Errors: none here. The pipeline ends a run whose total has changed or whose numbers are not finite.
