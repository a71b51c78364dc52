#pragma once
// A first scene for somebody's garment: spacing, time step, domain, pins and water that follow from its mesh.

#include <string>
#include <vector>

namespace drench {

struct FirstScene {
  std::string yaml;                   // with comments; loads and can be set up
  std::vector<std::string> warnings;  // one line each: about the mesh, its unit, and those of the set-up
};

/// @param mesh an .obj, .ply or .stl file, as the scene shall name it; "" for a square cloth without a file
/// @throws SetupError a mesh that cannot be read or cannot be cloth
FirstScene first_scene(const std::string& mesh);

}  // namespace drench
