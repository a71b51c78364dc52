#pragma once
// The ledger's accounts and the run's clock, on the host.

#include "state/host_state.hpp"

namespace drench::kokkos_backend {

struct Accounts {
  Quanta drained = 0;   // left the domain
  Quanta supplied = 0;  // came from jets and reservoirs (net)
  Quanta evaporated = 0;  // went into the air
  std::int64_t step = 0;
  double time = 0;  // s
};

}  // namespace drench::kokkos_backend
