#pragma once
// How much of a fresh particle's compression counts yet. Law: docs/theory/liquid.md, Eq. 25.

#include "core/types.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// β_i, 1. `age` and `ramp` in s; only what cloth has given out is ramped in.
KOKKOS_INLINE_FUNCTION Real source_ramp(std::uint8_t origin, Real age, Real ramp) {
  const bool fresh = origin == static_cast<std::uint8_t>(Origin::cloth) && age < ramp;
  return fresh ? age / ramp : Real(1);
}

}  // namespace drench::kokkos_backend
