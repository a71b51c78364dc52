#pragma once
// The lattices of distances of all bodies of a model.

#include <array>
#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Lays lattices around meshes with an inside; they reach as far as cloth is thick, or sticks when wet. `wetted`: where
/// liquid can be, m. Without the values.
void lay_body_fields(Model& model, const Box& wetted, std::vector<std::string>& warnings);

/// Distances of rigid bodies that earlier set-ups have computed, for a caller that sets up several variants of a scene.
class FilledBodies {
 public:
  /// Fills the lattice of a body as an earlier set-up did that of the same mesh. False: none had the same lattice.
  /// `thickness`: of the thickest cloth that moves, m; 0 without one.
  bool fill(Body& body, double thickness) const;
  void keep(const Body& body, double thickness);

 private:
  struct Filled {
    double thickness = 0;
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    DistanceField field;
    std::array<DistanceField, 2> parts;
  };
  std::vector<Filled> filled_;  // the latest last
};

/// Fills them; where cloth moves, also those between parts of a mesh.
void fill_body_fields(Model& model, FilledBodies* filled = nullptr);

}  // namespace drench
