#pragma once
// The constant part of a solid body, resolved from the scene, with the motion that is prescribed for it.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "scene/scene.hpp"

namespace drench {

/// Signed distance (m, negative inside) to a closed mesh or a part of it at t = 0 on a lattice, x fastest; empty for
/// all other bodies.
struct DistanceField {
  Vec3 origin{0, 0, 0};  // m: the first lattice point
  double spacing = 0;    // m
  std::array<Index, 3> points{0, 0, 0};
  std::vector<double> value;               // m
  static constexpr double nowhere = 2e30;  // m: where a part of a mesh is not there (Body::parts)
  bool empty() const { return value.empty(); }
  /// Which point of `whole`, a lattice that this one is cut from, its first point is.
  std::array<Index, 3> offset_in(const DistanceField& whole) const {
    std::array<Index, 3> offset{};
    for (std::size_t a = 0; a < 3; ++a)
      offset[a] = static_cast<Index>(std::lround((origin[a] - whole.origin[a]) / spacing));
    return offset;
  }
  std::size_t index(Index i, Index j, Index k) const { return (at(k) * at(points[1]) + at(j)) * at(points[0]) + at(i); }
};

/// A closed mesh whose points move from file to file, linearly in between: docs/theory/deforming_bodies.md. The
/// triangles are Body::mesh_triangles, turned outwards.
struct Deformation {
  std::vector<std::vector<Vec3>> points;  // m: of each file
  std::vector<double> time;               // s: of each file
  std::vector<Vec3> center;               // m: of each file's bounding box, which the lattice of distances follows
  std::vector<double> speed;              // m/s: of the fastest point from each file to the next
  double band = 0;                        // m: distances are cut off beyond it
  // of each sample: its triangle, and where it is in that, in affine weights (Σ = 1) and a depth below its plane, m
  std::vector<Index> triangle;
  std::vector<std::array<double, 3>> weight;
  std::vector<double> depth;

  bool empty() const { return points.empty(); }
};

/// A steady motion that a program has commanded, from `start` to `end`; then the body stands still.
struct CommandedMotion {
  double start = 0, end = 0;  // s
  Vec3 moved{0, 0, 0};        // m: displacement of the centre at `start` since t = 0
  Quaternion orientation{1, 0, 0, 0};
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};  // m/s, rad/s
};

struct Body {
  std::string name;
  BodyScene::Kind kind = BodyScene::Kind::box;
  // the shape at t = 0
  Box box;
  bool inside = false;
  // m: of a box, sphere or mesh's bounding box; of a dynamic mesh, its centre of mass; a plane's point. Bodies turn
  // about it
  Vec3 center{0, 0, 0};
  double radius = 0;
  Vec3 point{0, 0, 0};
  Vec3 normal{0, 1, 0};
  double reach = 0;  // m: no point of the surface (of a plane: within the domain) is farther from the centre
  // prescribed motion; of a dynamic body, how it starts
  Keyed<Vec3> velocity;                // m/s
  Keyed<Vec3> path;                    // m; 0 at t = 0; added to what the velocity does
  Vec3 spin_axis{0, 1, 0};             // unit
  Keyed<double> spin_rate;             // rad/s
  std::vector<Key<Quaternion>> turns;  // of a sequence, instead of these two: orientations at its files; evenly between
  double turn_rate = 0;                // rad/s: the fastest of them
  bool commanded = false;              // moved by a program instead
  bool probed = false;                 // a probe measures what acts on it
  CommandedMotion command;             // the last one
  Vec3 applied_force{0, 0, 0}, applied_torque{0, 0, 0};  // N, N m: what a program does to a dynamic body
  double adhesion = 0;                                   // w, N/m
  double slip = 0;                                       // b, m; inf: free
  // of a plane that moves: the steps of its samples' lattice and what they stay beside, m (src/stages/bodies.hpp, law
  // 1)
  std::array<Vec3, 2> lattice{};
  Vec3 middle{0, 0, 0};
  bool slides = false;
  bool dynamic = false;
  double mass = 0;                       // kg; 0 unless dynamic
  Vec3 inertia{0, 0, 0};                 // kg m²: about the centre and the principal axes
  Quaternion principal{1, 0, 0, 0};      // turns the axes of t = 0 to the principal ones
  double friction = 0, restitution = 0;  // 1: against other bodies
  Index first_sample = 0, sample_count = 0;
  std::vector<Vec3> mesh_points;  // m, at t = 0, for the picture; empty but for meshes
  std::vector<std::array<Index, 3>> mesh_triangles;
  DistanceField field;  // of a closed mesh
  // Where two parts of its surface face each other closely, the distance to each of them together with the rest of the
  // surface (setup/facing_parts.hpp). The first stands on the points of `field`; the second stands on those near the
  // parts and is `nowhere` where both would equal `field`. Deep below one part the other one is nowhere.
  std::array<DistanceField, 2> parts;
  Deformation shape;  // of one that changes its shape, whose pose stands still; else empty

  bool spins() const { return commanded || !spin_rate.is_zero() || !turns.empty(); }
  bool deforms() const { return !shape.empty(); }
  bool has_parts() const { return !parts[0].empty(); }
  /// Is what liquid and cloth do to it measured?
  bool is_measured() const { return dynamic || commanded || probed; }
  bool moves() const { return dynamic || deforms() || spins() || !velocity.is_zero() || !path.is_zero(); }
  /// Does its motion change with time by prescription (src/stages/prescribed_motion.hpp)?
  bool has_keys() const {
    return commanded || velocity.has_keys() || spin_rate.has_keys() || path.has_keys() || !turns.empty() || deforms();
  }
};

/// Of a step of the lattice: how far back the samples of a plane that moves are at most (src/stages/bodies.hpp, law 1).
inline constexpr double slide_offset = 0.38196601125010515;

/// Samples of the solid bodies at t = 0, all bodies concatenated.
struct BoundarySet {
  std::vector<Vec3> position;  // m
  std::vector<Index> body;
  // only where a body slips (docs/theory/viscosity.md): the wall that a sample stands for, at t = 0
  std::vector<Vec3> wall_normal;   // unit, towards the liquid
  std::vector<double> wall_depth;  // m: how far the sample lies below it; 0 in an open mesh, which has two sides
  Index count() const { return static_cast<Index>(position.size()); }
};

}  // namespace drench
