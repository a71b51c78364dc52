#pragma once
// The cloth's own stages: what each reads and writes.

#include "cloth/self_collision.hpp"
#include "cloth/solver.hpp"
#include "cloth/squeezing.hpp"
#include "cloth/wet_adhesion.hpp"

namespace drench::kokkos_backend {

/// The implicit step. `loaded`: nodes.force holds what the liquid's last pressure does to the nodes.
void cloth(const Constants& constants, Bodies& bodies, Cloth& cloth, ClothSolverWork& solver, bool loaded,
           const StepInfo& info, StepReport& report);

void self_collision(const Constants& constants, Bodies& bodies, Cloth& cloth, SelfCollisionWork& work,
                    const StepInfo& info, StepReport& report);

/// Presses the pores; `collision`: the pairs of stage self_collision in this step.
void squeezing(const Constants& constants, Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
               const SelfCollisionWork& collision, SqueezingWork& work, const StepInfo& info);

}  // namespace drench::kokkos_backend
