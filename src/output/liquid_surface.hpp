#pragma once
// The liquid's surface for the picture, made of its particles; no law of the run looks at it.

#include "output/grids.hpp"

namespace drench {

/// The level ½ of the liquid's field (output/liquid_field.hpp) as triangles: closed, normals outward; point fields normal
/// (1) and velocity (m/s, the particles' by their part in the field). Empty without liquid.
/// Contour.  Marching cubes (VTK's table of cases) on a lattice of scene.output.surface_spacing × d that exists only where
///           there is liquid, a block at a time: memory grows with particles and triangles, not with the domain.
/// Bumps.    The contour shows single particles. Taubin's filter (1995: λ = 0.5, μ = −0.53, keeps the volume) takes away
///           what is shorter than some spacings; drops of few particles, which are round and would suffer, are spared.
/// Solids.   A vertex in a body is put on the body's surface, one on the other side of a cloth than the particle nearest
///           to it back to that side, both 0.02 d short of it.
Grid surface_grid(const Model& model, const HostState& state);

}  // namespace drench
