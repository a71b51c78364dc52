#pragma once
// Forces that change velocities alone (DRENCH_FORCES in src/pipeline/stage_list.hpp): a function and its memory for
// each.

#include <memory>

#include "bodies/bodies.hpp"
#include "cloth/cloth.hpp"
#include "core/neighbor_list.hpp"
#include "particles/fluid.hpp"
#include "pipeline/stage_list.hpp"

namespace drench::kokkos_backend {

/// What a force reads and what it changes.
struct Forcing {
  const Constants& constants;
  const NeighborLists& lists;
  const Bodies& bodies;
  Fluid& fluid;
  Cloth& cloth;
  const StepInfo& info;
  std::shared_ptr<void>& work;  // what the force keeps between steps

  /// The same as the force's own type, made when it is first asked for.
  template <class Work>
  Work& kept() const {
    if (!work) work = std::make_shared<Work>();
    return *static_cast<Work*>(work.get());
  }
};

#define DRENCH_KOKKOS_FORCE(name, fastest) \
  void name(const Forcing& on);            \
  MemoryEstimate name##_bytes(const Sizing& s);
DRENCH_FORCES(DRENCH_KOKKOS_FORCE)
#undef DRENCH_KOKKOS_FORCE

}  // namespace drench::kokkos_backend
