#pragma once
// The lattices of distances of all bodies of a model.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Lays lattices around meshes with an inside; they reach as far as cloth is thick, or sticks when wet. `wetted`: where
/// liquid can be, m. Without the values.
void lay_body_fields(Model& model, const Box& wetted, std::vector<std::string>& warnings);
/// Fills them; where cloth moves, also those between parts of a mesh.
void fill_body_fields(Model& model);

}  // namespace drench
