#include "core/neighbor_search.hpp"

#include <cmath>
#include <type_traits>

#include "core/host_rows.hpp"
#include "core/liquid_pairs.hpp"

namespace drench::kokkos_backend {
namespace {

/// Which of the table's 32 entries from `first` on are near.
struct Lot32 {
  std::uint32_t near;
  Index first;
};

/// A GPU thread's work: one row, in two passes. The first compares distances and keeps a bit for each, without a
/// branch, for in a warp there is always a thread that finds something. Then the warp takes room for its rows, a bundle
/// of the list. The second pass writes what the bits say: the threads of a warp their k-th entries, which lie side by
/// side, at the same time.
template <class Points>
struct BundleSearch {
  using Team = Teams::member_type;
  static constexpr Index threads = team_threads;  // of a team
  static constexpr Index lots = 12;               // that a thread keeps: more than nine runs of cells need
  using Scratch = Kokkos::View<Lot32*, ExecSpace::scratch_memory_space, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

  static_assert(threads % rows_per_bundle == 0 && threads * lots * sizeof(Lot32) <= most_scratch(threads));

  const Search& search;

  /// Whether a dense table has anything in these cells: all loads under way at once, for most rows of some lists are
  /// empty.
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
  /// Without the entries of other cells in the same buckets.
  KOKKOS_INLINE_FUNCTION std::uint32_t in_run(std::uint32_t near, Index first, const CellRun& run) const {
    for (std::uint32_t left = near; left != 0; left &= left - 1) {
      const int k = Kokkos::Experimental::countr_zero_builtin(left);
      if (!run.holds(search.table.coord(first + k))) near &= ~(std::uint32_t(1) << k);
    }
    return near;
  }
  /// Calls keep(lot) for each lot of row i that has something near.
  template <class Keep>
  KOKKOS_INLINE_FUNCTION void find(Index i, const Keep& keep) const {
    const CellTableView& table = search.table;
    if (table.buckets == 0) return;
    const Real3 x = search.row_points(i);
    CellCoord lo, hi;
    search.cells_around(x, lo, hi);
    if (!search.in_order && !table.hashed && !any(lo, hi)) return;
    table.for_runs(lo, hi, [&](const Index first, const Index last, const CellRun& run) {
      for (Index e = first; e < last; e += 32) {
        std::uint32_t near = near_of(x, e, last - e < 32 ? last - e : 32);
        const auto self = static_cast<std::uint32_t>(i - e);
        if (search.in_order && self < 32) near &= ~(std::uint32_t(1) << self);
        if (table.hashed) near = in_run(near, e, run);
        if (near != 0) keep(Lot32{near, e});
      }
    });
  }
  /// Appends the first of a lot, and takes it out.
  template <class Writer>
  KOKKOS_INLINE_FUNCTION void append_first(Writer& row, Index i, Lot32& lot) const {
    Index j = lot.first + Kokkos::Experimental::countr_zero_builtin(lot.near);
    lot.near &= lot.near - 1;
    if (!search.in_order) {
      j = search.table.item(j);
      if (search.same_set && j == i) return;
    }
    row.put(j);
  }
  template <class Writer>
  KOKKOS_INLINE_FUNCTION void append(Writer& row, Index i, const Lot32* at, Index kept) const {
    Lot32 lot{0, 0};
    for (Index next = 0;;) {
      while (lot.near == 0 && next < kept) lot = at[threads * next++];
      if (lot.near == 0) return;
      append_first(row, i, lot);
    }
  }
  /// Has a lot anything that 16 bits from a bundle's base do not hold? A lot whose last places are beyond may be one
  /// that has.
  KOKKOS_INLINE_FUNCTION bool is_far(Lot32 lot, Index base) const {
    if (search.in_order) return lot.first < base || lot.first + 31 - base > 0xffff;
    for (; lot.near != 0; lot.near &= lot.near - 1) {
      const Index j = search.table.item(lot.first + Kokkos::Experimental::countr_zero_builtin(lot.near));
      if (j < base || j - base > 0xffff) return true;
    }
    return false;
  }
  /// The largest of a warp's numbers, in all its threads.
  KOKKOS_INLINE_FUNCTION static Index most_of_warp(Index n) {
#ifdef __CUDA_ARCH__
    for (int apart = warp_size / 2; apart > 0; apart /= 2) {
      const Index other = __shfl_xor_sync(~0u, n, apart);
      n = other > n ? other : n;
    }
#endif
    return n;
  }
  /// What the first thread of a warp has, in all its threads.
  KOKKOS_INLINE_FUNCTION static std::int64_t from_first_of_warp(std::int64_t value) {
#ifdef __CUDA_ARCH__
    return __shfl_sync(~0u, value, 0);
#else
    return value;
#endif
  }
  /// A row's entries, of which `kept` lots have been found; how many there are.
  template <class Writer>
  KOKKOS_INLINE_FUNCTION Index write(Writer row, Index i, const Lot32* at, Index kept) const {
    if (kept <= lots)
      append(row, i, at, kept);
    else  // more than it could keep
      find(i, [&](Lot32 lot) {
        while (lot.near != 0) append_first(row, i, lot);
      });
    row.finish();
    return row.count;
  }
  KOKKOS_INLINE_FUNCTION void fill(const Team& team, Index number) const {
    const Scratch scratch(team.team_scratch(0), static_cast<std::size_t>(threads * lots));
    const Index i = number * threads + static_cast<Index>(team.team_rank());
    Lot32* const mine = scratch.data() + team.team_rank();
    const Index base = CompactRow::base(i);
    Index found = 0, kept = 0, far = 0;
    if (i < search.rows)
      find(i, [&](const Lot32& lot) {
        found += Kokkos::Experimental::popcount_builtin(lot.near);
        if (search.compact && is_far(lot, base)) far = 1;
        if (kept < lots) mine[threads * kept] = lot;
        ++kept;
      });
    const Index width = most_of_warp(found);
    if (search.compact) far = most_of_warp(far);
    std::int64_t first = 0;
    if (i % rows_per_bundle == 0) {
      if (i == 0) *search.next_used = 0;
      const Index groups = (width + 3) / 4,
                  room = !search.compact ? width : groups * (far != 0 ? CompactRow::far_words : CompactRow::near_words);
      if (width > 0) first = search.take(std::int64_t{room} * rows_per_bundle);
    }
    first = from_first_of_warp(first);
    const bool fits = first >= 0;
    if (fits && far != 0) first = ~first;
    if (i % rows_per_bundle == 0 && i < search.rows) search.start(i / rows_per_bundle) = first;
    if (i >= search.rows) return;
    const bool writes = fits && found > 0;
    search.count(i) = !writes          ? 0
                      : search.compact ? write(CompactRowWriter(search.entry.data, first, i), i, mine, kept)
                                       : write(RowWriter(search.entry.data, first, i), i, mine, kept);
  }
};

/// Several lists in one kernel, so that none waits for the last rows of another.
template <class Points>
struct FillBundles {
  using One = BundleSearch<Points>;
  static constexpr int most_lists = 5;

  struct List {
    Search search;
    Index end = 0;  // of its teams
  };
  List list[most_lists];

  KOKKOS_INLINE_FUNCTION void operator()(const typename One::Team& team) const {
    const auto rank = static_cast<Index>(team.league_rank());
    int which = 0;
    while (rank >= list[which].end) ++which;
    One{list[which].search}.fill(team, which > 0 ? rank - list[which - 1].end : rank);
  }
};

/// Fills lists; of a GPU's as many at once as there are.
template <class Points>
void launch(const std::vector<Search>& searches) {
  if constexpr (std::is_same_v<Points, PointLanes>) {
    constexpr Index lot = FillRows<Points>::rows_at_once;
    for (const Search& search : searches)
      parallel("drench::neighbors::list", (search.rows + lot - 1) / lot, FillRows<Points>{search});
  } else {
    using Fill = FillBundles<Points>;
    using One = typename Fill::One;
    for (std::size_t from = 0; from < searches.size(); from += Fill::most_lists) {
      Fill fill;
      Index teams = 0;
      for (std::size_t k = 0; k < Fill::most_lists && from + k < searches.size(); ++k) {
        const Search& search = searches[from + k];
        teams += (search.rows + One::threads - 1) / One::threads;
        fill.list[k] = {search, teams};
      }
      Teams policy(exec(), teams, One::threads);
      policy.set_scratch_size(0, Kokkos::PerTeam(One::Scratch::shmem_size(One::threads * One::lots)));
      Kokkos::parallel_for("drench::neighbors::list", policy, fill);
    }
  }
}

void grow(NeighborList& list, std::int64_t entries) {
  make_room(list.entry, "drench::neighbors", static_cast<std::size_t>(entries));
}

void make_row_room(NeighborList& list, Index rows) {
  list.rows = rows;
  if (list.needed.data() == nullptr) {
    list.needed = Kokkos::View<std::int64_t, Kokkos::SharedHostPinnedSpace>("drench::neighbors::needed");
    list.used = Kokkos::View<std::int64_t[2], MemSpace>("drench::neighbors::used");
  }
  if (rows <= static_cast<Index>(list.count.extent(0))) return;
  const auto capacity = static_cast<std::size_t>(rows + rows / 4);
  make_room(list.count, "drench::neighbor_count", capacity);
  make_room(list.start, "drench::neighbor_start", capacity / rows_per_bundle + 1);
}

}  // namespace

static_assert(rows_per_bundle == 1 || rows_per_bundle == static_cast<Index>(list_bundle));

double room_for_entries(double entries) { return 1.25 * entries; }

namespace {

double list_bytes(double rows, double entries, double bytes_an_entry, const Sizing& s) {
  const double start = s.gpu ? double(sizeof(std::int64_t)) / list_bundle : sizeof(std::int64_t);
  return 1.25 * rows * (index_bytes + start) + room_for_entries(entries) * bytes_an_entry;
}

}  // namespace

double list_bytes(double rows, double entries, const Sizing& s) { return list_bytes(rows, entries, index_bytes, s); }

double liquid_list_bytes(double rows, double entries, const Sizing& s) {
  if (!s.compact_pairs()) return list_bytes(rows, entries, index_bytes + s.real, s);  // grad_factor
  // 16 bits reach as far as a layer of cells, two particles thick, of a cube of liquid of this size.
  const bool far = 2 * std::pow(rows, 2.0 / 3) > 32768;
  return list_bytes(rows, entries, far ? index_bytes : sizeof(std::uint16_t), s);
}

namespace {

Search search_for(const ListRequest& request, Real support) {
  NeighborList& list = *request.list;
  list.needed() = 0;
  std::int64_t* const used = list.used.data() + list.filling;
  std::int64_t* const next_used = list.used.data() + (1 - list.filling);
  list.filling = 1 - list.filling;
  return {.row_points = *request.row_points,
          .rows = list.rows,
          .table = request.table,
          .same_set = request.same_set,
          .in_order = request.in_order,
          .compact = request.compact,
          .h2 = support * support,
          .count = list.count,
          .start = list.start,
          .entry = list.entry,
          .used = used,
          .next_used = next_used,
          .needed = list.needed};
}

}  // namespace

void build_neighbor_list(const ListRequest& request, Real support) { build_neighbor_lists({request}, support); }

bool build_neighbor_lists(const std::vector<ListRequest>& requests, Real support) {
  std::vector<ListRequest> left;
  for (const ListRequest& request : requests) {
    request.list->rows = request.rows;
    request.list->compact = request.compact;
    if (request.rows == 0) continue;
    make_row_room(*request.list, request.rows);
    left.push_back(request);
  }
  const bool waits = !left.empty();
  while (!left.empty()) {
    std::vector<Search> searches;
    searches.reserve(left.size());
    for (const ListRequest& request : left) searches.push_back(search_for(request, support));
    launch<CellPoints>(searches);
    exec().fence("drench::neighbors::list");
    std::erase_if(left, [](const ListRequest& request) { return request.list->needed() == 0; });
    for (const ListRequest& request : left) grow(*request.list, request.list->needed() + request.list->needed() / 4);
  }
  return waits;
}

std::vector<std::vector<Index>> rows_on_host(const NeighborList& list) {
  std::vector<std::vector<Index>> rows(static_cast<std::size_t>(list.rows));
  if (list.rows == 0) return rows;
  const auto count = on_host_now(list.count);
  const auto start = on_host_now(list.start);
  const auto entry = on_host_now(list.entry);
  for (Index i = 0; i < list.rows; ++i) {
    const std::int64_t first = start(i / rows_per_bundle);
    const auto append = [&, i](const auto& row) {
      for (Index k = 0; k < row.count; ++k) rows[static_cast<std::size_t>(i)].push_back(row(k));
    };
    if (list.compact)
      append(CompactRow(entry.data(), first, i, count(i)));
    else
      append(NeighborRow{entry.data(), nullptr, first + i % rows_per_bundle, count(i)});
  }
  return rows;
}

}  // namespace drench::kokkos_backend
