#pragma once
// Numbers that are drawn: the same on any number of threads and ranks, for they follow from what they are for.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// u in [0, 1), drawn for a thing (its id or index) in a step: a hash of both (Steele, Lea and Flood 2014).
KOKKOS_INLINE_FUNCTION double drawn(std::int64_t thing, std::int64_t step) {
  std::uint64_t z = std::uint64_t(thing) * 0xD1B54A32D192ED03U + std::uint64_t(step) * 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  z ^= z >> 31;
  return double(z >> 11) * 0x1p-53;
}

}  // namespace drench::kokkos_backend
