#pragma once
// Stage permeation: how fast pressure drives liquid through wet cloth (Darcy's law across the sheet).
//
// Law:    docs/theory/porous.md, section 14. Stages absorption and emission let the liquid in on one side and out on
//         the other. The stage runs if a porous cloth has a permeability and direction, absorption and emission are on.
// Reads:  node_position, fluid_position (m), fluid_mass (quanta), fluid_kappa_density, fluid_kappa_divergence (m²/s²),
//         fluid_density_ratio (1), sample_volume (m³), list fluid→sample (sample→fluid). Where walls extrapolate,
//         boundary_position (m), boundary_volume (m³), list sample→boundary.
//         The running mean goes on from sample_flux (m/s).
// Writes: sample_flux, sample_flow_direction (1) of permeable cloth; within the step what of the flux passes (m/s) and
//         Σ V W upstream of each sample.
// Exact:  sums over liquid are 64-bit integers.
// Errors: none.
