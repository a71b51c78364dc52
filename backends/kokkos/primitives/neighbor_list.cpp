#include "primitives/neighbor_list.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace drench::kokkos_backend {
namespace {

/// Row i of a list while it is filled; what does not fit is counted only.
struct Row {
  Kokkos::View<Index**, MemSpace> list;
  Index i, width, count;  // the column `width` is there to be overwritten

  KOKKOS_INLINE_FUNCTION void append(Index j) {
    if (count < width) list(i, count) = j;
    ++count;
  }
};

/// What finds the rows' entries, and where these go.
struct Search {
  Array<Real3> row_points;
  Index rows;
  CellTableView table;
  bool same_set, in_order;  // ListRequest
  Real h2;                  // m²: the support's square
  Array<Index> count;
  Kokkos::View<Index**, MemSpace> list;
  Kokkos::View<Index, Kokkos::SharedHostPinnedSpace> longest;
  Index width;

  /// The cells [lo, hi] around a point, without those that a dense table does not have.
  KOKKOS_INLINE_FUNCTION void cells_around(const Real3& x, CellCoord& lo, CellCoord& hi) const {
    const CellCoord c = table.cell_of(x);
    lo = {c.x - 1, c.y - 1, c.z - 1};
    hi = {c.x + 1, c.y + 1, c.z + 1};
    table.clip(lo, hi);
  }
  KOKKOS_INLINE_FUNCTION void finish(const Row& row) const {
    count(row.i) = row.count;
    if (row.count > width) Kokkos::atomic_max(&longest(), row.count);
  }
};

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

/// Appends what is near of the table's entries [first, last): a CPU computes distances in vector registers, and stores each
/// entry, which is quicker than a branch that it cannot foresee. The table's points end in a lot of spare ones.
[[maybe_unused]] inline void append_near(Row& row, const CellTableView& table, const PointLanes& points, Index first,
                                         Index last, const CellCoord& cell, const Real3& x, Real h2, Index self) {
  const Real *px = points.x.data(), *py = points.y.data(), *pz = points.z.data();
  const Index* const item = table.item.data();
  Index* const out = &row.list(row.i, 0);
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
      if (table.hashed) one = table.coord(e + k) == cell ? one : 0;
      out[n < row.width ? n : row.width] = j;
      n -= one;
    }
  }
  row.count = n;
}

/// A CPU thread's work: one row. (Templates, so that only what a backend launches is compiled.)
template <class Points>
struct FillRow {
  Search search;

  KOKKOS_INLINE_FUNCTION void operator()(const Index i) const {
    const CellTableView& table = search.table;
    const Real3 x = search.row_points(i);
    const Index self = search.same_set ? i : Index(-1);
    Row row{search.list, i, search.width, 0};
    if (table.buckets > 0) {
      CellCoord lo, hi;
      search.cells_around(x, lo, hi);
      const Points& points = table.point;
      table.for_runs(lo, hi, [&](const Index first, const Index last, const CellCoord& c) {
        append_near(row, table, points, first, last, c, x, search.h2, self);
      });
    }
    search.finish(row);
  }
};

/// Which of the table's 32 entries from `first` on are near.
struct Lot32 {
  std::uint32_t near;
  Index first;
};

/// A GPU thread's work: one row, in two passes. The first compares distances and keeps a bit for each, without a branch, for in
/// a warp there is always a thread that finds something. The second appends what the bits say: the threads of a warp write
/// their k-th entries, which lie side by side, at the same time.
template <class Points>
struct FillRows {
  using Policy = Kokkos::TeamPolicy<ExecSpace, Kokkos::LaunchBounds<128, 1>>;
  using Team = typename Policy::member_type;
  using Scratch = Kokkos::View<Lot32*, ExecSpace::scratch_memory_space, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
  static constexpr Index threads = 128, lots = 12;  // of a team; that a thread keeps: more than nine runs of cells need

  Search search;

  /// Whether a dense table has anything in these cells: all loads under way at once, for most rows of some lists are empty.
  KOKKOS_INLINE_FUNCTION bool any(const CellCoord& lo, const CellCoord& hi) const {
    const CellTableView& table = search.table;
    if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return false;
    Index found = 0;
    for (int dz = 0; dz < 3; ++dz)
      for (int dy = 0; dy < 3; ++dy) {
        const int y = lo.y + dy < hi.y ? lo.y + dy : hi.y, z = lo.z + dz < hi.z ? lo.z + dz : hi.z;
        const Index first = (z * table.dims.y + y) * table.dims.x;
        found |= table.start(first + hi.x + 1) - table.start(first + lo.x);
      }
    return found != 0;
  }
  KOKKOS_INLINE_FUNCTION std::uint32_t near_of(const Real3& x, Index first, Index length) const {
    const Points& points = search.table.point;
    std::uint32_t near = 0;
    DRENCH_UNROLL
    for (Index k = 0; k < length; ++k) {
      const Real3 r = x - points(first + k);
      near |= (dot(r, r) < search.h2 ? std::uint32_t(1) : std::uint32_t(0)) << k;
    }
    return near;
  }
  /// The second pass. `at` are this thread's lots.
  KOKKOS_INLINE_FUNCTION void append(Row& row, const Lot32* at, Index kept) const {
    Lot32 lot{0, 0};
    for (Index next = 0;;) {
      while (lot.near == 0 && next < kept) lot = at[threads * next++];
      if (lot.near == 0) return;
      Index j = lot.first + Kokkos::Experimental::countr_zero_builtin(lot.near);
      lot.near &= lot.near - 1;
      if (!search.in_order) {
        j = search.table.item(j);
        if (search.same_set && j == row.i) continue;
      }
      row.append(j);
    }
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Team& team) const {
    const Scratch scratch(team.team_scratch(0), static_cast<std::size_t>(threads * lots));
    const Index i = static_cast<Index>(team.league_rank()) * threads + static_cast<Index>(team.team_rank());
    if (i >= search.rows) return;
    Lot32* const mine = scratch.data() + team.team_rank();
    const CellTableView& table = search.table;
    const Real3 x = search.row_points(i);
    CellCoord lo, hi;
    search.cells_around(x, lo, hi);
    Row row{search.list, i, search.width, 0};
    if (table.buckets > 0 && (search.in_order || table.hashed || any(lo, hi))) {
      Index kept = 0;
      table.for_runs(lo, hi, [&](const Index first, const Index last, const CellCoord& c) {
        for (Index e = first; e < last; e += 32) {
          std::uint32_t near = near_of(x, e, last - e < 32 ? last - e : 32);
          const auto self = static_cast<std::uint32_t>(i - e);
          if (search.in_order && self < 32) near &= ~(std::uint32_t(1) << self);
          if (table.hashed) near = in_cell(near, e, c);
          if (near == 0) continue;
          mine[threads * kept++] = {near, e};
          if (kept < lots) continue;
          append(row, mine, kept);
          kept = 0;
        }
      });
      append(row, mine, kept);
    }
    search.finish(row);
  }
  /// Without the entries of other cells in the same bucket.
  KOKKOS_INLINE_FUNCTION std::uint32_t in_cell(std::uint32_t near, Index first, const CellCoord& cell) const {
    for (std::uint32_t left = near; left != 0; left &= left - 1) {
      const int k = Kokkos::Experimental::countr_zero_builtin(left);
      if (!(search.table.coord(first + k) == cell)) near &= ~(std::uint32_t(1) << k);
    }
    return near;
  }
};

template <class Points>
void launch(const Search& search) {
  if constexpr (std::is_same_v<Points, PointLanes>) {
    parallel("drench::neighbors::list", search.rows, FillRow<Points>{search});
  } else {
    using Fill = FillRows<Points>;
    typename Fill::Policy policy((search.rows + Fill::threads - 1) / Fill::threads, Fill::threads);
    policy.set_scratch_size(0, Kokkos::PerTeam(Fill::Scratch::shmem_size(Fill::threads * Fill::lots)));
    Kokkos::parallel_for("drench::neighbors::list", policy, Fill{search});
  }
}

void grow(NeighborList& list, Index rows, Index width) {
  list.list = {};  // free before allocating
  list.list =
      Kokkos::View<Index**, MemSpace>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbors"), rows, width);
}

void make_room(NeighborList& list, Index rows) {
  list.rows = rows;
  if (list.longest.data() == nullptr)
    list.longest = Kokkos::View<Index, Kokkos::SharedHostPinnedSpace>("drench::neighbors::longest");
  if (rows <= static_cast<Index>(list.count.extent(0))) return;
  const Index capacity = rows + rows / 16;  // a row takes some hundred bytes, and as much again in `slope`
  list.count = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::neighbor_count"), capacity);
  grow(list, capacity, std::max<Index>(9, static_cast<Index>(list.list.extent(1))));
}

void fill(const ListRequest& request, Real support) {
  const NeighborList& list = *request.list;
  list.longest() = 0;
  launch<CellPoints>({request.row_points, list.rows, request.table, request.same_set, request.in_order,
                      support * support, list.count, list.list, list.longest,
                      static_cast<Index>(list.list.extent(1)) - 1});
}

/// Counts are those of whole rows, also of rows that are too long.
void pack(const ListRequest& request) {
  PackedRows& packed = *request.packed;
  const Index rows = request.rows;
  kokkos_backend::make_room(packed.start, "drench::neighbors::row_start", static_cast<std::size_t>(rows) + 1);
  if (packed.entries.data() == nullptr)
    packed.entries = Kokkos::View<Index, Kokkos::SharedHostPinnedSpace>("drench::neighbors::entries");
  const auto start = packed.start, count = request.list->count;
  parallel(
      "drench::neighbors::row_start", rows + 1, KOKKOS_LAMBDA(const Index i) { start(i) = i < rows ? count(i) : 0; });
  packed.sums.sum(start, rows + 1);
  Kokkos::deep_copy(ExecSpace(), packed.entries, Kokkos::subview(start, rows));
}

}  // namespace

void build_neighbor_list(const ListRequest& request, Real support) { build_neighbor_lists({request}, support); }

bool build_neighbor_lists(const std::vector<ListRequest>& requests, Real support) {
  std::vector<ListRequest> left;
  for (const ListRequest& request : requests) {
    request.list->rows = request.rows;
    if (request.rows == 0) continue;
    make_room(*request.list, request.rows);
    left.push_back(request);
  }
  const bool waits = !left.empty();
  bool first = true;
  while (!left.empty()) {
    for (const ListRequest& request : left) fill(request, support);
    for (const ListRequest& request : left)
      if (first && request.packed) pack(request);
    first = false;
    ExecSpace().fence("drench::neighbors::list");
    std::erase_if(left, [](const ListRequest& request) { return request.list->longest() == 0; });
    for (const ListRequest& request : left) {
      const Index widest = request.list->longest();
      grow(*request.list, static_cast<Index>(request.list->count.extent(0)), widest + widest / 4 + 5);
    }
  }
  return waits;
}

}  // namespace drench::kokkos_backend
