#pragma once
// The faces of a mesh as the mouth of an emitter.

#include <cstdint>
#include <string>
#include <vector>

#include "base/keyed.hpp"
#include "scene/scene.hpp"

namespace drench {

inline constexpr double max_face_points = 1e5;

/// Of each file of a mesh, for the same points of its faces.
struct EmittingFaces {
  Vec3 center{0, 0, 0};                       // m: of the first file's bounding box
  std::vector<double> time;                   // s: of each file
  std::vector<std::vector<Vec3>> points;      // m
  std::vector<std::vector<Vec3>> directions;  // unit: the faces' normals; empty if the scene gives the direction
  std::vector<Key<double>> area;              // m²: all that emits, linear between keys to 1e-5 of the largest
  // of a sequence: running sums over the points of what each emits, over what it does where the mesh emits the most
  std::vector<std::vector<double>> flow;
  double fastest = 0;  // m/s: of the points from file to file
};

/// Points about `spacing` (m) apart, about one per spacing², each in the middle of a part of the surface that emits as
/// much as any other: of the same area, or of the same area seen along the scene's direction, for which faces that look
/// the other way emit nothing. SetupError, beginning with `name`: files that cannot be read or have other triangles
/// than the first, points that are not finite, too many points or less than half a particle's, no face that emits.
EmittingFaces emitting_faces(const MeshJetScene& scene, const std::string& scene_path, double spacing,
                             const std::string& name);

/// The whole number without a common divisor with n that is nearest to n over the golden ratio: k · stride modulo n
/// visits all numbers, and those that follow each other are far apart, as are the visits to neighbours.
std::int64_t golden_stride(std::int64_t n);

}  // namespace drench
