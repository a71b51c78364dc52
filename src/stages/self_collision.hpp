#pragma once
// Stage self_collision: keeps the cloths with `self_collision: true` out of themselves and of each other. It changes
// node velocities until the straight paths of this step have no intersection. All arithmetic is in double.
//
// Law:    docs/theory/contacts.md, section 3. 1 solids, 2 conservative advancement, 3 contacts (impulses, friction),
//         4 impact zones, the failsafe.
// Reads:  node_position (m), node_velocity (m/s), node_liquid (quanta), time (s).
// Writes: node_velocity (m/s) of free nodes; StepReport::cloth_contacts (pairs), cloth_zone_nodes.
// Exact:  impulses are 64-bit sums in units of 2^-47 m/s times the mass of the heaviest node, wet; zones' momenta of
//         2^-47 m/s times that of all cloth.
// Errors: none here. Scenes that start with intersections are refused when they are loaded.
