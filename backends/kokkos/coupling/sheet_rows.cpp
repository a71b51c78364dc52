#include "coupling/sheet_rows.hpp"

#include <cmath>

#include "core/neighbor_search.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {
namespace {

/// The nodes around a particle, in the order of its samples, with what is added up for each. A node that comes when it
/// is full is a pair of its own every time: the sums stay right.
template <class Sum>
struct NodeTable {
  static constexpr int room = 12;

  Index node[room];
  Sum sum[room];
  int count = 0;

  /// Where the node is, or `room`.
  KOKKOS_INLINE_FUNCTION int find(Index n) {
    for (int k = 0; k < count; ++k)
      if (node[k] == n) return k;
    if (count == room) return room;
    node[count] = n;
    sum[count] = Sum{};
    return count++;
  }
};
struct Nothing {};

/// Visits the samples near a particle, a triangle after the other: most of a triangle's samples stand together.
struct SheetPairs {
  Kernel kernel;
  Neighbors near;
  Entries<const Real4> position, xs, offset;  // x_i and V_i; x_b and V_b; ½ d n_b
  Entries<const Real> ratio, weight;
  Entries<const Index> node, triangle;
  Real rest_density;

  /// What is read of a sample.
  struct Seen {
    Index triangle = -1, corner[3] = {};
    Real4 at, behind;
    Real weight[3] = {};
  };
  /// Calls each(seen), with the loads of some samples under way at once.
  template <bool all, class Each>
  KOKKOS_INLINE_FUNCTION void visit_samples(const NeighborRow& row, const Each& each) const {
    constexpr Index ahead = on_host ? 1 : 4;
    for (Index k = 0; k < row.count; k += ahead) {
      Index sample[ahead];
      Seen seen[ahead];
      for (Index a = 0; a < ahead; ++a) sample[a] = row(k + a < row.count ? k + a : k);
      for (Index a = 0; a < ahead; ++a) {
        const Index b = sample[a];
        seen[a].triangle = triangle(b);
        for (int c = 0; c < 3; ++c) seen[a].corner[c] = node(3 * b + c);
        if constexpr (all) {
          seen[a].at = xs(b);
          seen[a].behind = offset(b);
          for (int c = 0; c < 3; ++c) seen[a].weight[c] = weight(3 * b + c);
        }
      }
      for (Index a = 0; a < ahead && k + a < row.count; ++a) each(seen[a]);
    }
  }
  /// How many pairs with nodes it has.
  KOKKOS_INLINE_FUNCTION Index count(Index i) const {
    const NeighborRow row = near.row(i);
    if (row.count == 0) return 0;
    NodeTable<Nothing> table;
    Index single = 0, here = -1;
    visit_samples<false>(row, [&](const Seen& b) {
      if (b.triangle == here) return;
      here = b.triangle;
      for (int c = 0; c < 3; ++c) single += table.find(b.corner[c]) == table.room ? 1 : 0;
    });
    return table.count + single;
  }
  /// write(place in the row, node, p_in) for each of them.
  template <class Write>
  KOKKOS_INLINE_FUNCTION void visit(Index i, const Write& write) const {
    const NeighborRow row = near.row(i);
    if (row.count == 0) return;
    NodeTable<Real3> table;
    Index single = 0;
    Seen here;
    Real3 part[3];
    const auto take = [&] {
      for (int c = 0; c < 3 && here.triangle >= 0; ++c) {
        const int place = table.find(here.corner[c]);
        if (place < table.room)
          table.sum[place] += part[c];
        else
          write(table.room + single++, here.corner[c], part[c]);
        part[c] = {};
      }
    };
    const Real scale = mirrored * image_density(ratio(i));
    const Real3 x = position(i).xyz();
    visit_samples<true>(row, [&](const Seen& b) {
      if (b.triangle != here.triangle) {
        take();
        here = b;
      }
      const Real3 g = (scale * b.at.w) * kernel.gradient(from_behind(x - b.at.xyz(), b.behind.xyz()));
      for (int c = 0; c < 3; ++c) part[c] += b.weight[c] * g;
    });
    take();
    for (int k = 0; k < table.count; ++k) write(k, table.node[k], table.sum[k]);
  }
};

void make_row_room(SheetRows& rows, Index particles, Index nodes) {
  make_ample_room(rows.of_particle, "drench::sheet_rows::of_particle", static_cast<std::size_t>(particles) + 1);
  make_room(rows.of_node, "drench::sheet_rows::of_node", static_cast<std::size_t>(nodes) + 1);
}
void make_pair_room(SheetRows& rows, Index pairs) {
  const auto n = static_cast<std::size_t>(pairs);
  make_ample_room(rows.particle_pair, "drench::sheet_rows::particle_pair", n);
  make_ample_room(rows.node_pair, "drench::sheet_rows::node_pair", n);
  make_ample_room(rows.owner, "drench::sheet_rows::owner", n);
  make_ample_room(rows.sort.key, "drench::sheet_rows::key", n);
  make_ample_room(rows.sort.item, "drench::sheet_rows::item", n);
}

/// Counts, and where each particle's pairs begin.
Index count_pairs(const SheetPairs& pairs, SheetRows& rows, Index particles) {
  const Entries<Index> start = rows.of_particle;
  parallel(
      "drench::sheet_rows::count", particles + 1,
      KOKKOS_LAMBDA(const Index i) { start(i) = i < particles ? pairs.count(i) : 0; });
  rows.sums.sum(rows.of_particle, particles + 1);
  Index all = 0;
  copy_now(all, Kokkos::subview(rows.of_particle, particles));
  return all;
}

/// Where the pairs of each particle stand among those to be sorted by node: beside ghosts in the order of cells, as
/// they are without.
void place_in_order(const CellTableView& cells, SheetRows& rows, Index particles) {
  make_ample_room(rows.in_order, "drench::sheet_rows::in_order", static_cast<std::size_t>(particles) + 1);
  make_ample_room(rows.first_in_order, "drench::sheet_rows::first_in_order", static_cast<std::size_t>(particles));
  const Entries<const Index> start = rows.of_particle;
  const Entries<Index> place = rows.in_order, first = rows.first_in_order;
  const Array<Index> item = cells.item;
  parallel(
      "drench::sheet_rows::counts_in_order", particles + 1,
      KOKKOS_LAMBDA(const Index e) { place(e) = e < particles ? start(item(e) + 1) - start(item(e)) : 0; });
  rows.sums.sum(rows.in_order, particles + 1);
  parallel(
      "drench::sheet_rows::first_in_order", particles, KOKKOS_LAMBDA(const Index e) { first(item(e)) = place(e); });
}

void write_pairs(const SheetPairs& pairs, SheetRows& rows, Index particles, bool alone) {
  const Entries<const Index> start = rows.of_particle, sorted = alone ? rows.of_particle : rows.first_in_order;
  const Entries<SheetPair> pair = rows.particle_pair;
  const Entries<Index> owner = rows.owner, item = rows.sort.item;
  const Entries<PairSort::Key> key = rows.sort.key;
  parallel(
      "drench::sheet_rows::pairs", particles, KOKKOS_LAMBDA(const Index i) {
        const Index first = start(i), unsorted = sorted(i);
        pairs.visit(i, [&](const Index place, const Index n, const Real3& gradient) {
          const Index e = first + place;
          pair(e) = {gradient, n};
          owner(e) = i;
          item(unsorted + place) = e;
          key(unsorted + place) = static_cast<PairSort::Key>(n);
        });
      });
}

/// Where the first key stands that is not below `wanted`.
KOKKOS_INLINE_FUNCTION Index first_of(const Entries<const PairSort::Key>& key, Index count, PairSort::Key wanted) {
  Index first = 0, last = count;
  while (first < last) {
    const Index middle = first + (last - first) / 2;
    if (key(middle) < wanted)
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

/// The same pairs by node, in the order of the particles.
void turn(const SheetPairs& pairs, SheetRows& rows, Index nodes) {
  int bits = 1;
  while (nodes >> bits != 0) ++bits;
  sort_pairs(rows.sort, rows.count, bits);
  const Entries<const SheetPair> of_particle = rows.particle_pair;
  const Entries<SheetPair> of_node = rows.node_pair;
  const Entries<const Index> item = rows.sort.item, owner = rows.owner;
  const Entries<const PairSort::Key> key = rows.sort.key;
  const Entries<Index> start = rows.of_node;
  const Index count = rows.count;
  parallel(
      "drench::sheet_rows::by_node", count > nodes ? count : nodes + 1, KOKKOS_LAMBDA(const Index e) {
        if (e <= nodes) start(e) = first_of(key, count, static_cast<PairSort::Key>(e));
        if (e >= count) return;
        const Index from = item(e), i = owner(from);
        of_node(e) = {(pairs.rest_density * pairs.position(i).w) * of_particle(from).gradient, i};
      });
}

}  // namespace

void make_sheet_rows(const Constants& constants, const Fluid& fluid, const Cloth& cloth, NeighborLists& lists) {
  SheetRows& rows = lists.sheet_rows;
  const Index particles = fluid.particles.local(), nodes = cloth.nodes.count;
  make_row_room(rows, particles, nodes);
  const SheetPairs pairs{.kernel = constants.kernel,
                         .near = Neighbors(lists.fluid_sample),
                         .position = fluid.position_volume,
                         .xs = cloth.samples.position_volume,
                         .offset = cloth.samples.normal_offset,
                         .ratio = fluid.particles.density_ratio,
                         .weight = cloth.samples.weight,
                         .node = cloth.samples.node,
                         .triangle = cloth.samples.triangle,
                         .rest_density = constants.rest_density};
  rows.count = count_pairs(pairs, rows, particles);
  if (rows.count == 0) return;
  make_pair_room(rows, rows.count);
  if (!fluid.exchange.alone()) place_in_order(fluid.cells.view(), rows, particles);
  write_pairs(pairs, rows, particles, fluid.exchange.alone());
  turn(pairs, rows, nodes);
}

double sheet_row_bytes(const Sizing& s) {
  // Of a particle with m samples, q of which share a node: the nodes of the triangles that they lie in.
  const double m = 10, q = std::max(1.0, s.size.samples / std::max(1.0, s.size.nodes));
  const double share = std::min(3.0, 1 / q + 1.3 / std::sqrt(m * q) + 3 / m);
  const double pairs = share * s.entries.fluid_sample;
  return room_for_entries(pairs) * (8 * s.real + 5 * index_bytes) + (1.25 * s.size.fluid + s.size.nodes) * index_bytes;
}

}  // namespace drench::kokkos_backend
