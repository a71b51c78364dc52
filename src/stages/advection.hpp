#pragma once
// Stage advection: moves cloth and liquid, with continuous collision of liquid against cloth, failsafes, the domain's
// border and drains. Collisions are computed in double.
//
// Law:    docs/theory/contacts.md, sections 4–7. 0 coincident particles, 1 fresh particles, 2 cloth, 3 liquid against
//         cloth (paths, impulses), 4 failsafe of solids, 5 positions, ages and the domain, 6 tunnelled particles,
//         7 escaped particles. Liquid of files (docs/theory/liquid.md, Eq. 29g): 2, 5 and 7 only.
// Reads:  fluid_position (m), fluid_velocity (m/s), fluid_mass (quanta), fluid_age (s), fluid_origin, fluid_id,
//         node_position (m), node_velocity (m/s), node_contact_force (N), node_liquid (quanta), time (s),
//         lists fluid→fluid and fluid→sample.
// Writes: fluid_* (positions, velocities, ages; removed particles), node_position, node_velocity,
//         node_pin_force (N), drained (quanta);
//         StepReport::collisions, clamped, tunnelled, lowest_tunnelled, escaped, escaped_speed (m/s).
// Exact:  momentum for nodes is a 64-bit sum in units of q · 2^-8 m/s, applied once: v_n += p_n u_n.
// Solute: goes along with its liquid (docs/theory/solute.md): fluid_solute; solute_drained, solute_deposited (quanta).
// Errors: none here. Tunnelled and escaped particles are counted; pipeline/failure.hpp decides whether the run ends.
