#pragma once
// Equality of scenes.

#include "scene/scene.hpp"

namespace drench {

/// Do both say the same? Where a scene came from is no part of that.
inline bool same_scene(Scene a, const Scene& b) {
  a.path = b.path;
  return a == b;
}

}  // namespace drench
