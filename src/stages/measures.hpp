#pragma once
// Stage measures (`output: {measures: true}`): how clumped the liquid and how round the wet patch is. It changes
// nothing.
//
// Law:    docs/theory/porous.md, section 12.
// Reads:  fluid_position (m), fluid_mass, node_liquid (quanta), rest positions.
// Writes: StepReport::nearest_variance, close_share, wet_isotropy (1).
// Errors: none.
