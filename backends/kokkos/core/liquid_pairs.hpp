#pragma once
// How kernels read the list of the liquid with itself: neighbours, or pairs with the gradient's factor.

#include <type_traits>

#include "core/kernel.hpp"
#include "core/neighbor_list.hpp"

namespace drench::kokkos_backend {

/// FarFour neighbours, in 16 bits each counted from a bundle's base, or in 32 bits.
struct alignas(8) NearFour {
  std::uint32_t two[2];
};
struct alignas(16) FarFour {
  Index index[4];
};

/// A load of what is not wanted again: it leaves a GPU's nearest cache to what kernels gather.
KOKKOS_INLINE_FUNCTION NearFour load_once(const NearFour* p) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 750
  NearFour v;
  asm("ld.global.nc.L1::no_allocate.L2::128B.v2.u32 {%0,%1}, [%2];" : "=r"(v.two[0]), "=r"(v.two[1]) : "l"(p));
  return v;
#else
  return *p;
#endif
}
KOKKOS_INLINE_FUNCTION FarFour load_once(const FarFour* p) { return *p; }

/// A row of compact pairs. Groups of four neighbours, those of a bundle's 32 rows side by side; as many groups as the
/// bundle's longest row needs. A bundle has NearFour if no row reaches farther than 65536 rows from its base, else
/// FarFour. The last group of a row is filled up with the row itself.
struct CompactRow {
  static constexpr Index near_words = 2, far_words = 4;  // a group's

  const Index* first;  // group
  Index own, count;
  bool far;

  /// Bundles count their neighbours from here.
  KOKKOS_INLINE_FUNCTION static Index base(Index row) {
    const Index before = row / rows_per_bundle * rows_per_bundle - 32768;
    return before > 0 ? before : 0;
  }
  /// `start`: NeighborList's; the complement where the bundle is far.
  KOKKOS_INLINE_FUNCTION CompactRow(const Index* entry, std::int64_t start, Index row, Index neighbors)
      : first(entry + (start < 0 ? ~start : start) + row % rows_per_bundle * (start < 0 ? far_words : near_words)),
        own(row),
        count(neighbors),
        far(start < 0) {}

  KOKKOS_INLINE_FUNCTION Index operator()(Index k) const {
    const std::int64_t group = std::int64_t{k / 4} * rows_per_bundle;
    if (far) return reinterpret_cast<const FarFour*>(first)[group].index[k % 4];
    const std::uint32_t two = reinterpret_cast<const NearFour*>(first)[group].two[k % 4 / 2];
    return base(own) + static_cast<Index>(k % 2 == 0 ? two & 0xffffu : two >> 16);
  }
  /// Calls pair(j) for each neighbour. Of `lanes` threads that share a row each takes its own.
  template <Index lanes = 1, class Pair>
  KOKKOS_INLINE_FUNCTION void for_each(const Pair& pair, Index lane = 0) const {
    DRENCH_UNROLL
    for (Index k = lane; k < count; k += lanes) pair((*this)(k));
  }
  /// The same, and for what fills up the last group: faster. Each call is pair(j − origin, origin), with an origin that
  /// all calls have in common.
  template <Index lanes = 1, class Pair>
  KOKKOS_INLINE_FUNCTION void for_each_filled_up(const Pair& pair, Index lane = 0) const {
    if (far) {
      for_groups<lanes, FarFour>(lane, [&](const FarFour& now) {
        for (const Index j : now.index) pair(static_cast<std::uint32_t>(j), 0);
      });
      return;
    }
    const Index origin = base(own);
    for_groups<lanes, NearFour>(lane, [&](const NearFour& now) {
      pair(now.two[0] & 0xffffu, origin);
      pair(now.two[0] >> 16, origin);
      pair(now.two[1] & 0xffffu, origin);
      pair(now.two[1] >> 16, origin);
    });
  }

 private:
  /// The next group is under way while each(group) is called.
  template <Index lanes, class Group, class Each>
  KOKKOS_INLINE_FUNCTION void for_groups(Index lane, const Each& each) const {
    const Group* const group = reinterpret_cast<const Group*>(first);
    const Index groups = (count + 3) / 4;
    Group next{};
    if (lane < groups) next = load_once(group + lane * rows_per_bundle);
    DRENCH_ROLLED
    for (Index g = lane; g < groups; g += lanes) {
      const Group now = next;
      if (g + lanes < groups) next = load_once(group + (g + lanes) * rows_per_bundle);
      each(now);
    }
  }
};

/// Puts a row's neighbours one after the other.
struct RowWriter {
  Index* to;
  Index count = 0;

  /// `start`: as NeighborList has it.
  KOKKOS_INLINE_FUNCTION RowWriter(Index* entry, std::int64_t start, Index row)
      : to(entry + start + row % rows_per_bundle) {}
  KOKKOS_INLINE_FUNCTION void put(Index j) { to[std::int64_t{count++} * rows_per_bundle] = j; }
  KOKKOS_INLINE_FUNCTION void finish() {}
};

/// Puts a row's neighbours where CompactRow expects them.
struct CompactRowWriter {
  Index* to;
  Index row, base, count = 0;
  bool far;
  std::uint64_t four = 0;  // the last of them, those of near bundles

  KOKKOS_INLINE_FUNCTION CompactRowWriter(Index* entry, std::int64_t start, Index of_row)
      : row(of_row), base(start < 0 ? 0 : CompactRow::base(of_row)), far(start < 0) {
    to = entry + (far ? ~start : start) +
         (far ? CompactRow::far_words : CompactRow::near_words) * (row % rows_per_bundle);
  }
  KOKKOS_INLINE_FUNCTION void put(Index j) {
    const bool last = count++ % 4 == 3;
    if (far) {
      to[(count - 1) % 4] = j;
      if (last) to += CompactRow::far_words * rows_per_bundle;
      return;
    }
    four = four >> 16 | static_cast<std::uint64_t>(static_cast<std::uint32_t>(j - base)) << 48;
    if (!last) return;
    *reinterpret_cast<NearFour*>(to) = {{static_cast<std::uint32_t>(four), static_cast<std::uint32_t>(four >> 32)}};
    to += CompactRow::near_words * rows_per_bundle;
  }
  /// Fills up the last group with the row itself; the count stays.
  KOKKOS_INLINE_FUNCTION void finish() {
    const Index neighbors = count;
    while (count % 4 != 0) put(row);
    count = neighbors;
  }
};

/// The liquid's neighbours as kernels see them.
struct LiquidNeighbors {
  Entries<const Index> count;
  Entries<const std::int64_t> start;
  const Index* entry;
  const Real* factor;  // null where pairs are compact

  explicit LiquidNeighbors(const LiquidList& l)
      : count(l.count), start(l.start), entry(l.entry.data()), factor(l.grad_factor.data()) {}
  /// Where pairs are not compact.
  KOKKOS_INLINE_FUNCTION NeighborRow row(Index i) const {
    return {entry, factor, start(i / rows_per_bundle) + i % rows_per_bundle, count(i)};
  }
  KOKKOS_INLINE_FUNCTION CompactRow compact_row(Index i) const {
    return {entry, start(i / rows_per_bundle), i, count(i)};
  }
  /// Calls pair(j) for each neighbour j in the row's order.
  template <class Pair>
  KOKKOS_INLINE_FUNCTION void for_each(Index i, const Pair& pair) const {
    if constexpr (compact_pairs)
      compact_row(i).for_each(pair);
    else
      row(i).for_each(pair);
  }
};

/// The same with the gradient's factor of each pair, from stage density on.
struct LiquidPairs : LiquidNeighbors {
  Entries<const std::uint8_t> flags;
  Entries<const Real> volume;
  PairSlope slope;
  Real scale;  // 1/m⁵

  LiquidPairs(const LiquidList& l, const Kernel& kernel, const Field<Real>& volumes)
      : LiquidNeighbors(l), flags(l.flags), volume(volumes), slope(kernel.kind, kernel.h), scale(-kernel.grad_scale) {}

  // Where pairs are compact:
  /// Has a neighbour another volume than the particle itself?
  KOKKOS_INLINE_FUNCTION bool has_mixed_volumes(Index i) const { return (flags(i) & mixed_volumes) != 0; }
  /// Is it beside solids or sheets?
  KOKKOS_INLINE_FUNCTION bool is_bounded(Index i) const { return (flags(i) & bounded) != 0; }

  /// Calls pair(j, place(j), r, factor) for each neighbour j in the row's order, r = x_i − x_j, m; the gradient V_j
  /// ∇W_ij is factor · r. `place` has a particle's position and one number more.
  template <class Pair>
  KOKKOS_INLINE_FUNCTION void for_each(Index i, const Entries<const Real4>& place, const Pair& pair) const {
    visit<false, 1>(i, place, pair, 0);
  }
  /// The same, and perhaps some calls for i itself, with r = 0: faster, for sums to which a particle itself adds
  /// nothing. Of `lanes` threads that share a row each takes its own pairs; one alone where pairs are not compact.
  template <Index lanes = 1, class Pair>
  KOKKOS_INLINE_FUNCTION void for_each_or_self(Index i, const Entries<const Real4>& place, const Pair& pair,
                                               Index lane = 0) const {
    visit<true, lanes>(i, place, pair, lane);
  }

 private:
  template <bool or_self, Index lanes, class Pair>
  KOKKOS_INLINE_FUNCTION void visit(Index i, const Entries<const Real4>& place, const Pair& pair,
                                    [[maybe_unused]] Index lane) const {
    const Real3 here = place(i).xyz();
    if constexpr (compact_pairs) {
      const CompactRow near = compact_row(i);
      const Real own = scale * volume(i);
      if (!or_self || has_mixed_volumes(i)) {
        near.for_each<lanes>(
            [&](Index j) {
              const Real4 at = place(j);
              const Real3 r = here - at.xyz();
              pair(j, at, r, scale * volume(j) * slope(fused_square(r)));
            },
            lane);
      } else {
        const Real4* const from = place.data;
        near.for_each_filled_up<lanes>(
            [&](std::uint32_t k, Index origin) {
              const Real4 at = (from + origin)[k];
              const Real3 r = here - at.xyz();
              pair(static_cast<Index>(k) + origin, at, r, own * slope(fused_square(r)));
            },
            lane);
      }
    } else {
      row(i).for_each([&](Index j, Real stored) {
        const Real4 at = place(j);
        pair(j, at, here - at.xyz(), stored);
      });
    }
  }
};

/// For the stages that shorten or annotate the list.
struct WritableLiquidNeighbors : LiquidNeighbors {
  WritableNeighbors writable;  // its rows where pairs are not compact; its counts
  Entries<std::uint8_t> flags;

  explicit WritableLiquidNeighbors(LiquidList& l)
      : LiquidNeighbors(l), writable(static_cast<NeighborList&>(l)), flags(l.flags) {}
  /// Leaves the neighbours of a row that kept(j) is true of.
  template <class Kept>
  KOKKOS_INLINE_FUNCTION void shorten(Index i, const Kept& kept) const {
    if constexpr (compact_pairs) {
      CompactRowWriter left(writable.item, start(i / rows_per_bundle), i);
      compact_row(i).for_each([&](Index j) {
        if (kept(j)) left.put(j);
      });
      left.finish();
      writable.count(i) = left.count;
    } else {
      const WritableRow near = writable.row(i);
      Index left = 0;
      for (Index k = 0; k < near.count; ++k) {
        const Index j = near(k);
        if (!kept(j)) continue;
        if (left < k) near(left) = j;
        ++left;
      }
      writable.count(i) = left;
    }
  }
  /// Calls factor_of(j) for each neighbour, V_j (dW/dr)/r of the pair, and keeps it unless pairs are compact.
  template <class Factor>
  KOKKOS_INLINE_FUNCTION void keep_factors(Index i, const Factor& factor_of) const {
    if constexpr (compact_pairs) {
      compact_row(i).for_each(factor_of);
    } else {
      const WritableRow near = writable.row(i);
      DRENCH_UNROLL
      for (Index k = 0; k < near.count; ++k) near.grad_factor(k) = factor_of(near(k));
    }
  }
};

}  // namespace drench::kokkos_backend
