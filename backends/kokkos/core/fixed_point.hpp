#pragma once
// Sums as integers: the same in any order. A sum has a unit; a number is rounded to it once.

#include "core/double3.hpp"

namespace drench::kokkos_backend {

/// Momenta of liquid are summed in units of q · 2^-8 m/s.
inline constexpr double momentum_steps = 256;

/// Impulses on cloth nodes are summed in units of q · 2^-20 m/s.
inline constexpr double impulse_steps = 1048576;

/// `value`, given in the unit of the sum, at most ±2^62: a larger one has no place in the integer.
KOKKOS_INLINE_FUNCTION std::int64_t fixed_point(double value) {
  constexpr double largest = 4611686018427387904.0;
  return static_cast<std::int64_t>(Kokkos::round(smaller(larger(value, -largest), largest)));
}

/// Adds a vector, already in the sums' unit, to the three sums from 3 `at` on.
KOKKOS_INLINE_FUNCTION void add_fixed(const Entries<std::int64_t>& sums, Index at, const Double3& v) {
  Kokkos::atomic_add(&sums(3 * at), fixed_point(v.x));
  Kokkos::atomic_add(&sums(3 * at + 1), fixed_point(v.y));
  Kokkos::atomic_add(&sums(3 * at + 2), fixed_point(v.z));
}

}  // namespace drench::kokkos_backend
