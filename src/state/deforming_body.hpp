#pragma once
// Bodies that change their shape, at a time: docs/theory/deforming_bodies.md. `body` is one with Body::deforms().

#include "state/file_times.hpp"
#include "state/model.hpp"

namespace drench {

/// Right after a time (s): one over the time between its two files, 1/s; 0 before the first and from the last on.
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
