#pragma once
// Whether a body wears a garment, and where it would.

#include <optional>
#include <vector>

#include "setup/garment.hpp"
#include "state/model.hpp"

namespace drench {

/// Does the garment go around a part of the body? A sheet that lies at it never does. `body`: points of its mesh, m.
bool surrounds(const Garment& garment, const std::vector<Vec3>& body);
/// Is it in several pieces, none of which goes around a part of the body by itself? How many; else 0.
std::size_t pieces_beside(const Garment& garment, const std::vector<Vec3>& body);

/// A place of a garment at a body.
struct WornPlace {
  Vec3 shift{0, 0, 0};  // m, from where the garment is
  double gap = 0;       // m: root mean square of the distances of its nodes from the body; depths count four times
  double inside = 0;    // 1: share of its nodes inside the body
};

/// Where the garment is. `body` has a distance field.
WornPlace rate_place(const Garment& garment, const Body& body);

/// A garment with an axis of its file up, as it is and where the body wears it best.
struct Fitting {
  Garment garment;
  WornPlace given;
  bool around = false;  // does it go around a part of the body as it is?
  std::optional<WornPlace> moved;
};

/// Of the axes that can be up in the garment's file, the one with which it fits the body best, and the translation that
/// it needs for that. None where the garment stays as it is: where the body wears it, and where nothing fits better.
/// `file`: the points and triangles of the garment's file, which `label` names.
std::optional<Fitting> fit_to(const Garment& garment, const SurfaceMesh& file, const std::string& label,
                              const Body& body);

}  // namespace drench
