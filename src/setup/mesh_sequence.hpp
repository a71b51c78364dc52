#pragma once
// Meshes that move from file to file.

#include <string>

#include "setup/file_place.hpp"
#include "setup/surface_mesh.hpp"
#include "setup/weld.hpp"
#include "state/model.hpp"

namespace drench {

/// How far points of a rigid body move against each other at most, over the size of the mesh.
inline constexpr double rigid_tolerance = 1e-5;

/// body.path, .turns and .turn_rate, from the files of scene.sequence: the rigid motion of least squares (Kabsch 1976;
/// Umeyama 1991) that takes the points of the first to those of each. Where points move against each other by more than
/// rigid_tolerance, body.shape instead (setup/deforming_body.hpp). `body` has the mesh of the first; `source`: of each
/// of its points the file's. SetupError, beginning with `name`: other triangles, points that are not finite, and those
/// of deform().
void follow_sequence(Body& body, const BodyScene& scene, const std::string& scene_path, const std::string& name,
                     const std::vector<Index>& source);

/// Where the nodes of a cloth are in the files of a sequence, as keys of their distance from the first: one Keyed a
/// node. `file`: the cloth's mesh. `place` puts a file's points where the cloth is; `rest` are the cloth's own, and
/// `weld` knows which of a file's points is at each node. SetupError: another number of points, or a first file that is
/// not the cloth.
std::vector<Keyed<Vec3>> node_paths(const SequenceScene& sequence, const std::string& file,
                                    const std::string& scene_path, const std::vector<Vec3>& rest, const Weld& weld,
                                    const FilePlace& place, const std::string& name);

}  // namespace drench
