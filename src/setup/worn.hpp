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
  Vec3 shift{0, 0, 0};          // m, from where the garment is
  double gap = 0;               // m: mean distance of its nodes from the body, those inside count several times
  double inside = 0, deep = 0;  // 1: share of its nodes inside the body; m: of the deepest of them
};

/// Files of garments and bodies often have different origins: one at the hips, the other at the feet. The translation
/// after which the garment is nearest to the body with few nodes inside it, at most half as far on average; none where
/// the garment is well placed already or no such place goes around a part of the body. `body` has a distance field.
std::optional<WornPlace> find_worn_place(const Garment& garment, const Body& body);

}  // namespace drench
