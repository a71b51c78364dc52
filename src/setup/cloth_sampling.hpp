#pragma once
// Samples on the cloths' triangles, and the liquid that the cloths hold at the start.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// How many samples build_samples() makes.
double expected_cloth_samples(const Model& model);

/// m²: of all the cloths at rest.
double cloth_area(const Model& model);

/// Cuts each triangle into k² congruent ones, k = max(1, ⌈√area / sample_spacing⌉), with a sample at each one's
/// centroid, so that all samples of a triangle have the same area; fills model.samples and the sample ranges of
/// model.cloths.
void build_samples(Model& model);

/// Sets state.node_liquid and node_solute from `initial_stain`, `initial_saturation` and `hold_saturation`, and fills
/// model.reservoirs. Later boxes override earlier ones. A box without nodes becomes a warning. Needs model.samples and
/// model.quantum. SetupError: the cloth is not porous, a value above max_saturation.
void fill_cloths(Model& model, HostState& state, std::vector<std::string>& warnings);

}  // namespace drench
