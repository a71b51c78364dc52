#pragma once
// Neighbour lists and how kernels read them.

#include <type_traits>

#include "core/cached.hpp"
#include "core/pair_sort.hpp"

namespace drench::kokkos_backend {

/// A GPU in float keeps of a pair of the liquid nothing but where the neighbour is, in 16 bits, and finds the
/// gradient's factor anew from the positions: its iterations wait for bytes, not for arithmetic
/// (docs/dev/gpu_speed.md).
#if defined(KOKKOS_ENABLE_CUDA) && !defined(DRENCH_DOUBLE)
inline constexpr bool compact_pairs = true;
#else
inline constexpr bool compact_pairs = false;
#endif

/// Neighbours in CSR layout: rows are stored back to back, so memory is the sum of the row lengths. On a GPU 32 rows
/// form a bundle as wide as its longest row and interleave (sliced ELLPACK), so that a warp reads coalesced. Where a
/// bundle lies depends on timing; what it holds does not.
struct NeighborList {
  Field<Index> count;
  Field<std::int64_t> start;  // where a bundle's entries begin
  Field<Index> entry;
  // Beside `entry`, kept by stage density for the step: V_j (dW/dr)/r, 1/m², of a particle with another (unless pairs
  // are compact) and with a solid's sample.
  Field<Real> grad_factor;
  Index rows = 0;
  bool compact = false;  // pairs as CompactRow has them
  // While it is filled: entries given out by this filling and by the next one; how many were asked for, if too many.
  Kokkos::View<std::int64_t[2], MemSpace> used;
  Kokkos::View<std::int64_t, Kokkos::SharedHostPinnedSpace> needed;
  int filling = 0;
};

#ifdef KOKKOS_ENABLE_CUDA
inline constexpr Index rows_per_bundle = warp_size;
#else
inline constexpr Index rows_per_bundle = 1;
#endif
static_assert(!on_host || rows_per_bundle == 1, "a thread of the host fills rows of its own");

/// The list of the liquid with itself, which kernels read as LiquidNeighbors and LiquidPairs (core/liquid_pairs.hpp).
struct LiquidList : NeighborList {
  Field<std::uint8_t> flags;  // of a row, from stage density: see RowFlag; where pairs are compact
};
enum RowFlag : std::uint8_t { mixed_volumes = 1, bounded = 2 };  // bounded: beside solids or sheets

/// One row as kernels see it. `index_of(k)` says where entry k is in arrays beside the entries.
template <class Item, class Factor>
struct BasicNeighborRow {
  Item* item;
  Factor* factor;  // null without factors
  std::int64_t first;
  Index count;

  KOKKOS_INLINE_FUNCTION std::int64_t index_of(Index k) const { return first + std::int64_t{k} * rows_per_bundle; }
  KOKKOS_INLINE_FUNCTION Item& operator()(Index k) const { return item[index_of(k)]; }
  /// V_j (dW/dr)/r of the pair, 1/m².
  KOKKOS_INLINE_FUNCTION Factor& grad_factor(Index k) const { return factor[index_of(k)]; }
  /// Calls pair(j), or pair(j, V_j (dW/dr)/r), for each neighbour j in the row's order.
  template <class Pair>
  KOKKOS_INLINE_FUNCTION void for_each(const Pair& pair) const {
    DRENCH_UNROLL
    for (Index k = 0; k < count; ++k) {
      if constexpr (std::is_invocable_v<const Pair&, Index, Real>)
        pair((*this)(k), grad_factor(k));
      else
        pair((*this)(k));
    }
  }
};

/// A list as kernels see it.
template <class Item, class Factor>
struct BasicNeighbors {
  using Row = BasicNeighborRow<Item, Factor>;

  Entries<Item> count;
  Entries<const std::int64_t> start;
  Item* item;
  Factor* factor;

  template <class List>
  requires(!compact_pairs || !std::is_base_of_v<LiquidList, List>) explicit BasicNeighbors(List& l)
      : count(l.count), start(std::as_const(l).start), item(l.entry.data()), factor(l.grad_factor.data()) {}
  KOKKOS_INLINE_FUNCTION Row row(Index i) const {
    return {item, factor, start(i / rows_per_bundle) + i % rows_per_bundle, count(i)};
  }
  template <class Pair>
  KOKKOS_INLINE_FUNCTION void for_each(Index i, const Pair& pair) const {
    row(i).for_each(pair);
  }
};

using NeighborRow = BasicNeighborRow<const Index, const Real>;
using Neighbors = BasicNeighbors<const Index, const Real>;
/// For the stages that fill, shorten or annotate a list.
using WritableRow = BasicNeighborRow<Index, Real>;
using WritableNeighbors = BasicNeighbors<Index, Real>;

/// Which rows of a list have any entries (core/filled_rows.hpp).
struct FilledRows {
  Index rows = 0;  // that were looked at
  Field<Index> row;
  Kokkos::View<Index, MemSpace> count;
};

/// A particle beside a sheet with one of its nodes, in one load of 16 bytes in float.
struct alignas(4 * sizeof(Real)) SheetPair {
  Real3 gradient;  // p_in, 1/m, beside a particle; ρ0 V_i p_in, kg/m, beside a node
  Index other;
};

/// The pairs of the liquid with sheets as the pressure solves read them, from stage density (coupling/sheet_rows.hpp).
struct SheetRows {
  Field<Index> of_particle, of_node;  // where a row begins
  Field<SheetPair> particle_pair, node_pair;
  Index count = 0;
  Field<Index> owner;  // of particle_pair
  Field<Index> in_order,
      first_in_order;  // of particles beside ghosts: where their pairs are before they are sorted by node
  PairSort sort;
  PrefixSums sums;
};

/// Every list of a run, named `row_neighbour`. Liquid: its particles; boundary: samples of solids; sample: of cloths.
struct NeighborLists {
  LiquidList fluid_fluid;
  NeighborList fluid_boundary, fluid_sample, sample_fluid;
  FilledRows near_sheet;                 // of fluid_sample; on a GPU
  Cached<NeighborList> sample_sample;    // of the nodes' positions
  Cached<NeighborList> sample_boundary;  // of the nodes' and the bodies' positions
  NeighborList boundary_fluid;           // rows: the samples of dynamic bodies
  SheetRows sheet_rows;
};

}  // namespace drench::kokkos_backend
