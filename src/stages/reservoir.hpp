#pragma once
// Stage reservoir: nodes inside `hold_saturation` boxes are set to their target mass, Model::reservoirs.
//
// Law:    docs/theory/porous.md, section 8.
// Reads and writes: node_liquid, node_buffered (quanta; at most what the node holds then), supplied (quanta; the signed
// difference).
// Solute: goes along with its liquid (docs/theory/solute.md): node_solute, solute_supplied (quanta).
// Errors: none.
