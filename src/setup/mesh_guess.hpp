#pragma once
// The unit and the upward axis that a mesh file of a garment or a body likely has.

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "setup/surface_mesh.hpp"

namespace drench {

struct MeshGuess {
  LengthUnit unit = LengthUnit::m;
  UpAxis up = UpAxis::y;
  std::string unit_reason, up_reason;  // "" where it is the default and nothing speaks against it
};

/// Box around points as they are in the file.
Box bounds_of(const std::vector<Vec3>& points);

/// Of one file alone: beyond 5 units long it is centimetres, beyond 300 millimetres. Up is the axis that begins at the
/// ground while the other one is centred on the origin, else the longer one of y and z; a flat mesh lies in x and z.
MeshGuess guess_of(const Box& file_box);
/// The same of a body: from 5 to 30 units it is decimetres, in which it is a person (MakeHuman).
MeshGuess guess_of_body(const Box& file_box);
/// Of a garment: that of the body where the garment lies at the body then.
MeshGuess guess_beside(const Box& file_box, const Box& body_file_box, const MeshGuess& body);

/// SetupError: a file whose size fits none of the units that are guessed.
void check_guess(const Box& file_box, const MeshGuess& guess, const std::string& label);

/// A file's box in metres, y up.
Box upright_box(const Box& file_box, const MeshGuess& guess);

}  // namespace drench
