#pragma once
// Stage emission: the cloth gives back what it holds above capacity (paper Eqs. 9, 10). Masses in quanta.
//
// Law:    docs/theory/porous.md, section 5: the excess matures in a buffer (node_buffered), then leaves (a) to liquid
//         in the cone, (b) not at all where a solid is in the cone, (c) to other layers, (d) as a new particle; (e) the
//         rest stays. Section 11: without `processes: direction` there is no cone. Section 16: films.
// Reads:  positions (m), velocities (m/s), fluid_mass, node_liquid, node_buffered (quanta), sample_flow_direction (1),
//         lists fluid→sample (sample→fluid), sample→sample, sample→boundary.
// Writes: node_liquid, node_buffered (quanta), node_velocity, node_pin_force (c), fluid_mass, fluid_velocity (a),
//         fluid_* appended (d; ids in the order of the collectors), next_id.
// Exact:  momentum of (c) is a 64-bit sum in units of q · 2^-8 m/s.
// Solute: goes along with its liquid (docs/theory/solute.md): fluid_solute, node_solute (quanta).
// Errors: none.
