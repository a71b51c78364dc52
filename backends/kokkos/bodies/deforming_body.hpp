#pragma once
// Bodies that change their shape: their surface, distances to it, and their samples. Law:
// docs/theory/deforming_bodies.md.

#include <array>
#include <limits>

#include "bodies/bodies.hpp"

namespace drench::kokkos_backend {

/// One of them. The lattice of distances is divided into blocks of block_edge³ points.
struct DeformingBody {
  static constexpr Index block_edge = 2;

  DeformingBody(const Body& body, Index index);

  const Body& body;  // of the model
  Index index, points, triangles, first_sample, samples;
  Real band, step;  // m: of distances; between lattice points
  std::array<Index, 3> lattice, blocks;
  Field<Index> corner, neighbor;   // three a triangle: points, and the triangle opposite to each
  Field<Index> point_start, item;  // triangles of a point, as 4 triangle + corner
  Field<Index> sample_triangle;
  Field<Double3> sample_weight;
  Field<double> sample_depth;  // m
  // points of files, as doubles, and which files these are
  std::array<Field<Double3>, 4> file;
  std::array<std::int64_t, 4> held{-1, -1, -1, -1};
  // at the end of the step from `time` that lasts `dt`; relative to the lattice's origin then
  double time = std::numeric_limits<double>::quiet_NaN(), dt = 0;
  bool stands = false;                                   // it stood still in that step
  Field<Real3> position, velocity;                       // m, m/s: velocities are means over the step
  Field<Real3> face_normal, point_normal;                // unit, 0 of a triangle without area; any length
  Field<Real4> ball;                                     // around each triangle: centre and radius, m
  Field<Real> block_bound;                               // m: no block's centre is farther from the surface
  Field<Index> block_count, block_start, near_triangle;  // triangles that may be the nearest of a point of a block
  Field<Real> distance;                                  // m
  Field<Index> nearest;
};

/// Points of a mesh between two files, m.
struct PointsBetween {
  Entries<const Double3> first, last;
  double part;
  KOKKOS_INLINE_FUNCTION Double3 operator()(Index n) const {
    const Double3 a = first(n);
    return add(a, times(part, minus(last(n), a)));
  }
};
/// At both ends of a step; uploads the files that are not held yet.
struct PointsOfStep {
  PointsBetween begin, end;
};
PointsOfStep points_of_step(DeformingBody& body, double time, double dt);

/// bodies.deforming, for their constructor.
void make_deforming(const Constants& constants, Bodies& bodies);

MemoryEstimate deforming_bytes(const Sizing& s);

/// Their surfaces and distances at the end of the step, and their entries of bodies.solids.
void place_surfaces(Bodies& bodies, const StepInfo& info);

/// Velocities of their samples: the way over the step, divided by it.
void set_sample_velocities(Bodies& bodies, const StepInfo& info);

/// Positions of their samples at a time (s), and the velocities right after it.
void place_deforming_samples(Bodies& bodies, double time);

/// Volumes of their samples where they are (Eq. 1 of docs/theory/walls_and_sheets.md).
void refresh_sample_volumes(const Constants& constants, Bodies& bodies);

}  // namespace drench::kokkos_backend
