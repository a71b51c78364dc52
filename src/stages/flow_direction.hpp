#pragma once
// Stage flow_direction: where the liquid in porous cloth wants to go: down, and away from solids (paper Eqs. 4–6).
//
// Law:    docs/theory/porous.md, section 3. With `processes: {direction: off}` (section 11) the stage does not run and
//         sample_flow_direction stays 0.
// Reads:  node_position, boundary_position (m), boundary_volume (m³), list sample→boundary.
// Writes: sample_flow_direction (1; 0 for samples of cloth that is not porous).
// Errors: none.
