#pragma once
// Bodies that change their shape, at a time: docs/theory/deforming_bodies.md. `body` is one with Body::deforms().

#include "state/model.hpp"

namespace drench {

/// Between which two files a time (s) lies: points are (1 − part) first + part last.
struct FilePart {
  std::size_t first = 0, last = 0;
  double part = 0;  // 1, in [0, 1]
};
FilePart files_at(const Deformation& shape, double time);

/// The files a second by which points move from `first` to `last` right after a time (s); 0 before the first and from
/// the last on.
double rate_after(const Deformation& shape, double time);

/// m
std::vector<Vec3> points_at(const Deformation& shape, double time);

/// Where the lattice of distances (Body::field has its spacing and extent) begins at a time, m.
Vec3 lattice_origin(const Body& body, double time);

/// The speed of the fastest point in [from, to], s; m/s.
double fastest_point(const Deformation& shape, double from, double to);
/// At any time.
double fastest_point(const Deformation& shape);

}  // namespace drench
