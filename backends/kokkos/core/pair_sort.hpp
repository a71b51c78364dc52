#pragma once
// Pairs of a key and an item, sorted by key, where those with the same key stay in their order; and sums of counts.

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// The pairs, and what the sort takes beside them.
struct PairSort {
  using Key = std::uint32_t;
  Array<Key> key, next_key;
  Array<Index> item, next_item;
  Array<Index> place;           // of a host's sort
  Array<std::uint8_t> scratch;  // of a GPU's
};

/// Sorts the first `count` pairs by the lowest `bits` of their keys. Exchanges the arrays for others of the same size.
void sort_pairs(PairSort& pairs, Index count, int bits);

/// Exclusive sums of integers, in place; what it needs beside them is kept. (On CUDA CUB's, which reads and writes each
/// once.)
class PrefixSums {
 public:
  /// a(k) becomes Σ_{l<k} a(l), k < n.
  void sum(const Array<Index>& a, Index n);

 private:
  Array<std::uint8_t> scratch_;
};

}  // namespace drench::kokkos_backend
