#pragma once
// Stage absorption: the cloth takes up liquid (paper Eqs. 7, 8). Masses in quanta, q = m0/2^32 kg.
//
// Law:    docs/theory/porous.md, section 4 (demand, supply, transfer), section 10 (limiter of the nodes), section 11
//         (`processes: direction` and `saturation_control`).
// Reads:  fluid_position, node_position (m), fluid_velocity (m/s), fluid_mass and node_liquid (quanta),
//         sample_flow_direction (1), list fluid→sample. Saturations are those before the stage.
// Writes: fluid_mass, node_liquid (quanta), node_velocity (m/s; fixed nodes keep theirs), node_pin_force (N).
//         Particles of mass 0 are removed, order kept: by the reference here, by the Kokkos backend at the end of stage
//         emission, or here if that is off.
// Exact:  momentum is a 64-bit sum in units of q · 2^-8 m/s.
// Solute: goes along with its liquid (docs/theory/solute.md): fluid_solute, node_solute (quanta).
// Errors: none.
