#pragma once
// One layer of samples at spacing d, half a spacing below the surface of each body (after Akinci et al. 2012).

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "state/model.hpp"

namespace drench {

inline constexpr double max_body_samples = 20e6;

/// How many samples sample_body() makes, found without making them: exact for boxes and planes, of the whole surface
/// for spheres, an estimate on the high side for meshes.
double expected_body_samples(const Body& body, double spacing, WallPressure walls, const Box& region, int layer = 0);

/// The steps of the lattice that a plane is sampled on, m.
std::array<Vec3, 2> plane_lattice(const Body& body, double spacing);

/// Where samples of the body can be at t = 0 that reach `region` (the domain extended by h) within `duration` (s): the
/// region itself, swept against the body's velocity (of planes along the normal, and by a step of the lattice); for
/// bodies that turn or float everything (planes: as much about the domain's middle as the region is wide, in that
/// layer).
Box sampled_region(const Body& body, const Box& region, double duration, int layer = 0);

/// The samples of one body within `region`, in an order that depends on the arguments alone: d/2 inside the solid
/// (dynamic bodies between mirrored walls 0.67 d), on the surface of meshes that are not closed. Each shape has a
/// pattern of its own (body_sampling.cpp).
std::vector<Vec3> sample_body(const Body& body, double spacing, WallPressure walls, const Box& region, int layer = 0);

/// The body whose surface the samples of a layer lie on: half a spacing inside the solid (dynamic bodies between
/// mirrored walls 0.67 d), each further layer d deeper. Closed meshes sink each sample instead.
Body sampled_surface(Body body, double d, WallPressure walls, int layer);

/// Of a mesh's samples: the triangles that they lie in; −1 of a vertex without one.
std::vector<Index> triangles_of_samples(const Body& body, double spacing, const Box& region);

/// A point of a mesh's surface moved d/2 inside along the distance field's gradient; where the solid is too thin for
/// that, d/4, or not at all (m).
Vec3 sunk(const Body& body, double d, const Eigen::Vector3d& p);

/// Calls offer(point, triangle that it lies in) for points of a mesh's surface: vertices (the triangle is −1 at one
/// without), then edges, then faces, at most 0.3 d apart in each.
void for_surface_points(const Body& body, double d, const std::function<void(const Eigen::Vector3d&, Index)>& offer);

/// No two samples of a mesh are closer, in d.
inline constexpr double mesh_min_distance = 0.75;

/// How many layers of samples, spacing apart, a wall needs so that no liquid before it sees its end: one up to h = 2 d,
/// two up to 3 d, …; fewer where the solid has no room for them, one for meshes.
int body_layers(const Body& body, double spacing, double support);

}  // namespace drench
