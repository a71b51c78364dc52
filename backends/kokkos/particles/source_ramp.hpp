#pragma once
// How much of a fresh particle's compression counts yet. Law: docs/theory/liquid.md, Eq. 25.

#include "core/types.hpp"
#include "stages/jets.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

/// β_i, 1. `age` and `ramp` in s; ramped in is what comes from cloth, by `ramp`, and from mouths.
KOKKOS_INLINE_FUNCTION Real source_ramp(std::uint8_t origin, Real age, Real ramp) {
  if (origin == static_cast<std::uint8_t>(Origin::mouth))
    ramp = Real(mouth_ramp);
  else if (origin != static_cast<std::uint8_t>(Origin::cloth))
    return 1;
  return age < ramp ? age / ramp : Real(1);
}

}  // namespace drench::kokkos_backend
