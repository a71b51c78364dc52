#pragma once
// The liquid's surface for the picture, made of its particles; no law of the run looks at it.

#include "output/grids.hpp"

namespace drench {

/// The level ½ of the liquid's field (output/liquid_field.hpp) as triangles: closed, normals outward; point fields
/// normal (1) and velocity (m/s, the particles' by their part in the field). Empty without liquid. How it is contoured,
/// smoothed and kept off solids, the same bits for any number of threads: docs/dev/liquid_surface.md.
Grid surface_grid(const Model& model, const HostState& state, int threads = 1);

}  // namespace drench
