#pragma once
// Bodies that change their shape, at set-up: docs/theory/deforming_bodies.md.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Makes `body` one whose points go through `points` (m), those of its mesh in each file of a sequence at its
/// time (s). Its triangles
/// are turned outwards. `labels` are names of the files, which begin the text of a SetupError: a mesh that is not
/// closed, one whose surface has one side only, a shell whose inside is turned out.
void deform(Body& body, std::vector<std::vector<Vec3>> points, std::vector<double> times,
            const std::vector<std::string>& labels);

/// Lines about what happens between its files, each beginning with `name`.
std::vector<std::string> deformation_warnings(const Body& body, const std::string& name);

/// Lays body.field and the band for bodies of this spacing (m): distances of `margin` (m) are exact, and so is the
/// depth of what the surface passes in a step that is `longest` (s) or takes it `farthest` (m).
void lay_deforming_field(Body& body, double spacing, double margin, double longest, double farthest);

/// The body as it is at a time (s): a mesh that keeps its shape, without a distance field.
Body shape_at(const Body& body, double time);
/// The same with its field.
Body shape_with_field_at(const Body& body, double time);

/// Binds samples to its triangles (Deformation::triangle, …), so many that in no file a point of the surface is much
/// farther than d (m) from one; returns where they are at t = 0, m.
std::vector<Vec3> bind_samples(Body& body, double d);

/// Velocities of the bound samples right after t = 0, m/s.
std::vector<Vec3> first_velocities(const Body& body);

/// Of each triangle the largest area in any file, m².
std::vector<double> largest_areas(const Body& body);

/// About how many pairs of a triangle and a block of 2³ lattice points are listed.
double near_pairs(const Body& body);

}  // namespace drench
