#pragma once
// Signed distance fields of closed meshes, computed at set-up.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "setup/surface_distance.hpp"
#include "state/model.hpp"

namespace drench {

/// The most points of a lattice: 0.5 GB in double precision, and some seconds to fill.
constexpr double most_field_points = 6.4e7;

/// How the lattice lies around the mesh: spacing half of `spacing` (m), or more where that would need more than
/// most_field_points, `margin` (m) beyond its bounding box, and at least one cell more. Without the values.
DistanceField lay_field(const Body& body, double spacing, double margin);
/// The same around the box [min, max], m.
DistanceField lay_field(const Vec3& min, const Vec3& max, double spacing, double margin);

/// What a lattice that is coarser than half of `spacing` means, for a warning; "" for others.
std::string coarse_field(const DistanceField& field, double spacing);

/// Of each triangle of the body's mesh: 1 if it lies within the solid, where parts of the mesh overlap.
std::vector<std::uint8_t> hidden_triangles(const Body& body, const WindingNumber& winding, int threads);

/// The signed distance (m) to the body's mesh, exact to its triangles.
std::function<double(const Vec3&)> exact_distance(const Body& body);

/// The distances, exact to the triangles at all points nearer to the surface than about eight steps of the lattice;
/// farther away between exact ones four steps apart. They are negative where the mesh's winding number is 1 or more.
/// The mesh must be closed and turned outwards (setup/solid_mesh.hpp). The same bits with any number of threads.
void fill_field(const Body& body, DistanceField& field, int threads = 1);

/// Trilinear value (m) at x, and the unit vector of its gradient; far away (1e30, 0) beyond the lattice.
double field_distance(const DistanceField& field, const Vec3& x, Vec3& normal);

}  // namespace drench
