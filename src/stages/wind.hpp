#pragma once
// Stage wind: the drag of moving air on cloth and, where `wind.liquid_drag` is above 0, on free liquid.
//
// Law:    docs/dev/add_a_force.md, section 1: the air (Eq. 1), cloth (2 to 5), liquid (6 to 8).
// Reads:  time (s), node_position (m), node_velocity (m/s), node_liquid, fluid_mass (quanta), fluid_position (m), lists
//         of the liquid; the scene's `wind`.
// Writes: node_velocity, fluid_velocity (m/s), node_pin_force (N).
// Errors: none. The drag is implicit in the relative velocity: no Δt overshoots the air's.
