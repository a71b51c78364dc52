#pragma once
// Whether a body wears a garment, and where it would.

#include <optional>
#include <vector>

#include "setup/garment.hpp"
#include "state/model.hpp"

namespace drench {

/// Does the garment go around a part of the body? A sheet that lies at it never does. `body`: points of its mesh, m.
bool surrounds(const Garment& garment, const std::vector<Vec3>& body);

/// A place of a garment at a body.
struct WornPlace {
  Vec3 shift{0, 0, 0};  // m, from where the garment is
  double gap = 0;       // m: root mean square of the distances of its nodes from the body; depths count four times
  double inside = 0;    // 1: share of its nodes inside the body
};

/// Finds the translation that puts a garment on a body: files of both often have different origins, one at the hips,
/// the other at the feet. None where the garment is well placed already, or where no place that goes around a part of
/// the body has at most 0.4 of its gap. `body` has a distance field.
std::optional<WornPlace> find_worn_place(const Garment& garment, const Body& body);

}  // namespace drench
