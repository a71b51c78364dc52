#pragma once
// Hinges that the pressure solves know: docs/theory/bodies.md, (5b).

#include <algorithm>

#include "state/model.hpp"

namespace drench {

/// The hinge that leaves a body one turn: its only one, to the world or to a body that is not dynamic; null if it has
/// no such hinge.
inline const Joint* hinge_of_body(const Model& model, Index body) {
  const Joint* found = nullptr;
  for (const Joint& j : model.joints) {
    if (j.body != body && j.other != body) continue;
    const bool free = j.other >= 0 && model.bodies[static_cast<std::size_t>(j.other)].dynamic;
    if (found || j.body != body || free) return nullptr;
    found = &j;
  }
  return found;
}

/// Is there a body with such a hinge?
inline bool has_held_body(const Model& model) {
  return std::any_of(model.joints.begin(), model.joints.end(),
                     [&](const Joint& j) { return hinge_of_body(model, j.body) != nullptr; });
}

}  // namespace drench
