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

/// What a first scene is for. Files are as the scene shall name them.
struct FirstSceneFor {
  std::string mesh;         // an .obj, .ply or .stl file; "" for a square cloth without a file
  std::string body = "";    // the mesh of a body that wears it, or a pattern of names for an animated one; "" for none
  std::string fabric = "";  // its name, or a .yaml file with one; "" for a cotton shirt's weight and round numbers
  MeshPaths paths = MeshPaths::as_given;
  double body_rate = 24;  // 1/s: files of an animated body per second
};

/// @param trial finds out whether the steps converge; without it they are only estimated
/// @throws SetupError a mesh that cannot be read or cannot be cloth, or an unknown fabric
FirstScene first_scene(const FirstSceneFor& wanted, const TrySteps& trial = {});

}  // namespace drench
