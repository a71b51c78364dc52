#pragma once
// Particles in a volume, moved until none is denser than at rest, also beside a wall along the volume's surface.

#include <functional>
#include <vector>

#include "base/types.hpp"
#include "scene/liquid.hpp"

namespace drench {

/// How deep x lies below the surface (m, negative outside); `inward` becomes the unit vector to greater depth.
using Depth = std::function<double(const Vec3& x, Vec3& inward)>;

/// Moves particles of `volume` (m³) each that are closer to the surface than 2.5 spacings. Their density over that at
/// rest, with liquid beyond the surface as beyond a plane wall at depth s, is
///   ρ_i = V Σ_j W_ij + B(s_i),   B(s) = ∫ W beyond a plane at distance s,
/// and constraints ρ_i ≤ 1 are projected as in Position Based Fluids (Macklin and Müller 2013, Eqs. 8 to 12, without
/// its artificial pressure) where ρ_i is above 1.005, until the largest is below 1.01, at most 100 times. `support` in
/// m.
void relax_points(std::vector<Vec3>& points, double volume, const Depth& depth, KernelKind kernel, double support);

}  // namespace drench
