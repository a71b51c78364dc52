#pragma once
// Stage reservoir: nodes inside `hold_saturation` boxes are set to their target mass; the (signed) difference enters
// `supplied`. Law.  m_n := round(value · C_n/q) quanta (Model::reservoirs).   Reads and writes: node_liquid, supplied.
