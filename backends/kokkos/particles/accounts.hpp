#pragma once
// The ledger's accounts and the run's clock, on the host.

#include "state/host_state.hpp"

namespace drench::kokkos_backend {

struct Accounts {
  Quanta drained = 0;     // left the domain or entered a drain
  Quanta supplied = 0;    // came from jets and reservoirs (net)
  Quanta evaporated = 0;  // went into the air
  std::int64_t step = 0;
  double time = 0;  // s
  // of the solute, in its own quanta
  Quanta solute_drained = 0, solute_supplied = 0;
  Quanta solute_deposited = 0;  // left behind where a particle vanished from around it
};

}  // namespace drench::kokkos_backend
