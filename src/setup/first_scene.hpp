#pragma once
// A first scene for somebody's garment: spacing, time step, domain, pins and water that follow from its mesh.

#include <functional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace drench {

class FilledBodies;  // setup/body_fields.hpp

struct FirstScene {
  std::string yaml;                   // with comments; loads and can be set up
  std::vector<std::string> warnings;  // one line each: about the mesh, its unit, and those of the set-up
};

/// Runs a scene's first steps in memory: do they all converge? The last argument is for `build`.
using TrySteps = std::function<bool(const Scene&, FilledBodies&)>;

/// How the scene names mesh files.
enum class MeshPaths { as_given, absolute };

/// @param mesh an .obj, .ply or .stl file, as the scene shall name it; "" for a square cloth without a file
/// @param body the mesh of a body that wears it, or a pattern of names for an animated one; "" for none
/// @param trial finds out whether the steps converge; without it they are only estimated
/// @param body_rate files of an animated body per second, 1/s
/// @throws SetupError a mesh that cannot be read or cannot be cloth
FirstScene first_scene(const std::string& mesh, const std::string& body = "", const TrySteps& trial = {},
                       MeshPaths paths = MeshPaths::as_given, double body_rate = 24);

}  // namespace drench
