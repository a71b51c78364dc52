#pragma once
// How a thread of a host finds the rows of a neighbour list (core/neighbor_search.cpp).

#include <algorithm>
#include <array>
#include <cstring>

#include "core/row_search.hpp"
#include "host/isa.hpp"

namespace drench::kokkos_backend {

/// As many numbers as a vector register of the machine that is compiled for holds.
#if defined(__AVX512F__)
constexpr int register_bytes = 64;
#elif defined(__AVX__)
constexpr int register_bytes = 32;
#else
constexpr int register_bytes = 16;
#endif
using Lot [[gnu::vector_size(register_bytes)]] = Real;
constexpr Index lot_size = register_bytes / sizeof(Real);
static_assert(lot_size <= PointLanes::spare);

/// A row while a CPU fills it; what does not fit is counted only.
struct HostRow {
  Index* item;
  Index width, count;  // item[width] is there to be overwritten
};

/// Appends what is near of the table's entries [first, last): a CPU computes distances in vector registers, and stores
/// each entry, which is quicker than a branch that it cannot foresee. The table's points end in a lot of spare ones.
inline void append_near(HostRow& row, const CellTableView& table, const PointLanes& points, Index first, Index last,
                        const CellRun& run, const Real3& x, Real h2, Index self) {
  const Real *px = points.x.data(), *py = points.y.data(), *pz = points.z.data();
  const Index* const item = table.item.data();
  Index* const out = row.item;
  Index n = row.count;
  for (Index e = first; e < last; e += lot_size) {
    Lot rx, ry, rz;
    std::memcpy(&rx, px + e, sizeof(Lot));
    std::memcpy(&ry, py + e, sizeof(Lot));
    std::memcpy(&rz, pz + e, sizeof(Lot));
    rx = x.x - rx;
    ry = x.y - ry;
    rz = x.z - rz;
    const auto near = rx * rx + ry * ry + rz * rz < h2;  // −1 or 0
    const Index most = last - e < lot_size ? last - e : lot_size;
    for (Index k = 0; k < most; ++k) {
      const Index j = item[e + k];
      Index one = static_cast<Index>(near[k]) & (j != self ? -1 : 0);
      if (table.hashed) one = run.holds(table.coord(e + k)) ? one : 0;
      out[n < row.width ? n : row.width] = j;
      n -= one;
    }
  }
  row.count = n;
}

/// The runs of cells around a row, entries [first, last) of each, and what is looked for in them.
struct RowRuns {
  static constexpr int most = 18;  // a brick of a hashed table may end within each of nine

  const Real *x = nullptr, *y = nullptr, *z = nullptr;  // of the table's points
  const Index* item = nullptr;
  Real3 at{};
  Real h2 = 0;
  Index self = -1;
  CellCoord lo{0, 0, 0}, hi{-1, -1, -1};
  int runs = 0;
  Index first[most] = {}, last[most] = {};
  bool distinct = true;  // no entry stands in two of them: in a hashed table two cells may share a bucket

  void add(Index from, Index to) {
    first[runs] = from;
    last[runs++] = to;
  }
  bool are_distinct() const {
    for (int k = 1; k < runs; ++k)
      for (int other = 0; other < k; ++other)
        if (first[k] < last[other] && first[other] < last[k]) return false;
    return true;
  }
};
using NearOfRow = Index (*)(const RowRuns&, Index*, Index);

#ifdef DRENCH_SEVERAL_ISAS
/// Where the lanes that a mask of 8 bits takes lie, a byte each, the first lowest.
constexpr std::array<std::uint64_t, 256> pack_lanes() {
  std::array<std::uint64_t, 256> lanes{};
  for (unsigned mask = 0; mask < 256; ++mask)
    for (unsigned lane = 0, to = 0; lane < 8; ++lane)
      if (mask >> lane & 1) lanes[mask] |= std::uint64_t{lane} << (8 * to++);
  return lanes;
}
constexpr std::array<std::uint64_t, 256> packed_lanes = pack_lanes();
#endif

}  // namespace drench::kokkos_backend

#define DRENCH_ISA_FILE "core/near_of_row.inl"
#include "host/for_each_isa.hpp"

namespace drench::kokkos_backend {

/// For this processor; null: append_near does it.
inline NearOfRow near_of_row() {
#if defined(DRENCH_SEVERAL_ISAS) && !defined(DRENCH_DOUBLE)
  if (best_isa() == Isa::avx512) return isa_avx512::near_of_row;
  if (best_isa() == Isa::avx2) return isa_avx2::near_of_row;
#endif
  return nullptr;
}

/// A CPU thread's work: some rows, found into its own memory and then put where there is room for them together.
/// (Templates, so that only what a backend launches is compiled.)
template <class Points>
struct FillRows {
  static constexpr Index rows_at_once = 16, width = 511;  // a longer row is searched twice

  Search search;
  NearOfRow near = near_of_row();

  /// The runs of the cells [lo, hi], which are often those of the row before.
  void find_runs(const CellCoord& lo, const CellCoord& hi, RowRuns& runs) const {
    if (lo == runs.lo && hi == runs.hi) return;
    runs.lo = lo;
    runs.hi = hi;
    runs.runs = 0;
    search.table.for_runs(lo, hi, [&](const Index first, const Index last, const CellRun&) {
      if (first != last) runs.add(first, last);
    });
    runs.distinct = !search.table.hashed || runs.are_distinct();
  }
  Index find(Index i, Index* item, Index most, RowRuns& runs) const {
    const CellTableView& table = search.table;
    if (table.buckets == 0) return 0;
    const Real3 x = search.row_points(i);
    const Index self = search.same_set ? i : Index(-1);
    CellCoord lo, hi;
    search.cells_around(x, lo, hi);
    if (near != nullptr && most == width) {
      find_runs(lo, hi, runs);
      if (runs.distinct) {
        runs.at = x;
        runs.self = self;
        return near(runs, item, most);
      }
    }
    const Points& points = table.point;
    HostRow row{item, most, 0};
    table.for_runs(lo, hi, [&](const Index first, const Index last, const CellRun& run) {
      append_near(row, table, points, first, last, run, x, search.h2, self);
    });
    return row.count;
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index lot) const {
    Index found[rows_at_once][width + 17];
    const Index first = lot * rows_at_once,
                here = search.rows - first < rows_at_once ? search.rows - first : rows_at_once;
    const Points& points = search.table.point;
    RowRuns runs{.x = points.x.data(),
                 .y = points.y.data(),
                 .z = points.z.data(),
                 .item = search.table.item.data(),
                 .h2 = search.h2};
    std::int64_t entries = 0;
    for (Index r = 0; r < here; ++r) {
      const Index n = search.count(first + r) = find(first + r, found[r], width, runs);
      entries += n <= width ? n : n + 1;
    }
    if (lot == 0) *search.next_used = 0;
    std::int64_t at = search.take(entries);
    for (Index r = 0; r < here; ++r) {
      const Index n = search.count(first + r);
      search.start(first + r) = at;
      if (at < 0) continue;
      if (n <= width)
        std::copy_n(found[r], n, search.entry.data + at);
      else
        find(first + r, search.entry.data + at, n, runs);
      at += n <= width ? n : n + 1;
    }
  }
};

}  // namespace drench::kokkos_backend
