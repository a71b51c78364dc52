#pragma once
// The wall that each sample of a body stands for: docs/theory/viscosity.md, Slip.

#include <vector>

#include "state/model.hpp"

namespace drench {

/// Appends to set.wall_normal and set.wall_depth those of the samples (m) of one layer, as sample_body made them within
/// `region`; of a body that changes its shape, as bind_samples made them. An edge of a box gets the mean of its faces.
void add_wall_planes(const Body& body, double spacing, WallPressure walls, const Box& region, int layer,
                     const std::vector<Vec3>& samples, BoundarySet& set);

}  // namespace drench
