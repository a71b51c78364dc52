#pragma once
// The stages that look at the whole state: the time step, the ledger, measures, fabric.

#include "step/fabric.hpp"
#include "step/ledger.hpp"
#include "step/measures.hpp"

namespace drench::kokkos_backend {

void time_step(const Constants& constants, const Fluid& fluid, const Bodies& bodies, Cloth& cloth,
               Cached<StateMeasures>& measured, const StepInfo& info, StepReport& report);
void ledger(const Constants& constants, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth,
            Cached<StateMeasures>& measured, Accounts& accounts, const StepInfo& info, StepReport& report);

}  // namespace drench::kokkos_backend
