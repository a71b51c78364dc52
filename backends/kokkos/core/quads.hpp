#pragma once
// Sums over a row's pairs on a host, of vectors with a fourth number beside them: four at once in a register, and four
// sums in turn, so that an addition need not wait for the one before. Pair k goes to sum k modulo 4.

#include <cstring>

#include "core/neighbor_list.hpp"
#include "host/isa.hpp"

#ifdef DRENCH_LANES

namespace drench::kokkos_backend {

using Quad [[gnu::vector_size(4 * sizeof(Real))]] = Real;

inline Quad quad(const Real4& v) {
  Quad q;
  std::memcpy(&q, &v, sizeof(q));
  return q;
}

/// Σ term(j, factor) over a row.
template <class Term>
[[gnu::always_inline]] inline Quad sum_of_quads(const NeighborRow& row, const Term& term) {
  const Index* const item = row.item + row.first;
  const Real* const factor = row.factor + row.first;
  Quad first{}, second{}, third{}, fourth{};
  Index k = 0;
  for (; k + 4 <= row.count; k += 4) {
    first += term(item[k], factor[k]);
    second += term(item[k + 1], factor[k + 1]);
    third += term(item[k + 2], factor[k + 2]);
    fourth += term(item[k + 3], factor[k + 3]);
  }
  if (k < row.count) first += term(item[k], factor[k]);
  if (k + 1 < row.count) second += term(item[k + 1], factor[k + 1]);
  if (k + 2 < row.count) third += term(item[k + 2], factor[k + 2]);
  return (first + third) + (second + fourth);
}

/// x, y and z of four vectors.
struct FourVectors {
  Quad x, y, z;
  explicit FourVectors(const Quad (&v)[4])
      : FourVectors(__builtin_shufflevector(v[0], v[1], 0, 4, 1, 5), __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5),
                    __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7), __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7)) {}
  Quad sum() const { return x + y + z; }

 private:
  FourVectors(const Quad& xy, const Quad& other_xy, const Quad& zw, const Quad& other_zw)
      : x(__builtin_shufflevector(xy, other_xy, 0, 1, 4, 5)),
        y(__builtin_shufflevector(xy, other_xy, 2, 3, 6, 7)),
        z(__builtin_shufflevector(zw, other_zw, 0, 1, 4, 5)) {}
};

}  // namespace drench::kokkos_backend

#endif
