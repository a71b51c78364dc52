#pragma once
// Where the camera stands, so that a run fills the picture.

#include <vtkRenderer.h>

#include <vector>

#include "base/types.hpp"
#include "view/named_view.hpp"

namespace drench {

/// Points the camera so that `points` (m) fill the picture but for a margin. `up` is a unit vector, `aspect` width over
/// height.
void place_camera(vtkRenderer* renderer, const View& view, const Vec3& up, const std::vector<Vec3>& points,
                  double aspect);

}  // namespace drench
