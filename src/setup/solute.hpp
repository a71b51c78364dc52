#pragma once
// The solute of a scene at its start, in quanta of its own (docs/theory/solute.md).

#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Finds model.concentration_unit: the largest concentration that the scene names, kg/kg, and 0 if it names none. A
/// stain counts as if the fabric's pores were full. Needs model.cloths and model.rest_density.
void set_concentration_unit(Model& model);

/// Quanta of solute in so many quanta of liquid at a concentration in kg/kg; 0 without a solute.
Quanta solute_quanta(const Model& model, double concentration, Quanta liquid);

/// m²: of each node at rest, a third of its triangles.
std::vector<double> node_area(const Model& model);

/// Sets the solute of the particles of blocks, whose numbers are `block`, from 0. Nothing without a solute.
void dissolve_in_blocks(const Model& model, const std::vector<std::size_t>& block, HostState& state);

/// Names sources whose solute is so thin beside the scene's largest that its quanta are few.
void warn_of_thin_solute(const Model& model, std::vector<std::string>& warnings);

/// Adds the stains of `initial_stain` to state.node_solute. A box without nodes becomes a warning.
void add_stains(const Model& model, HostState& state, std::vector<std::string>& warnings);

}  // namespace drench
