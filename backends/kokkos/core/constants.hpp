#pragma once
// What stays the same during a run: the model, and its numbers in the backend's precision.

#include "core/kernel.hpp"
#include "core/types.hpp"
#include "parallel/communicator.hpp"
#include "state/model.hpp"

namespace drench::kokkos_backend {

struct Constants {
  explicit Constants(const Model& m, const Communicator* communicator = nullptr);

  const Model& model;
  const Communicator* ranks;            // null: one alone
  Real spacing, support, rest_density;  // d and h, m; ρ0, kg/m³
  Kernel kernel;
  double quantum;                    // q, kg
  Real3 gravity;                     // m/s²
  Real3 field_center, field_square;  // c, m; Ω², 1/s²
};

}  // namespace drench::kokkos_backend
