#pragma once
// The backend's arrays as other programs see them, without a copy.

#include <vector>

#include "bodies/bodies.hpp"
#include "cloth/cloth.hpp"
#include "particles/fluid.hpp"
#include "state/field_view.hpp"

namespace drench::kokkos_backend {

/// A view of each field that the model needs, in the table's order. The views of bodies that do not move are of a copy.
std::vector<FieldView> field_views(const Model& model, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth);

}  // namespace drench::kokkos_backend
