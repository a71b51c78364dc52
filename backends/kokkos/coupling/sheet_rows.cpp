#include "coupling/sheet_rows.hpp"

#include <cmath>

#include "core/filled_rows.hpp"
#include "core/neighbor_search.hpp"
#include "coupling/wall.hpp"

namespace drench::kokkos_backend {
namespace {

/// The nodes around a particle, in the order of its samples, with what is added up for each; a row's lanes share them. A node
/// that comes when it is full is a pair of its own every time: the sums stay right.
template <class Sum>
struct NodeTable {
  static constexpr int own = on_host ? 12 : 2, room = own * row_lanes;

  Index lane, node[own];
  Sum sum[own];
  int count = 0;

  KOKKOS_INLINE_FUNCTION explicit NodeTable(Index of_row) : lane(of_row) {}
  /// The place of this lane's k-th entry.
  KOKKOS_INLINE_FUNCTION int place(int k) const { return k * row_lanes + lane; }
  /// Adds to a node; returns whether there was room.
  KOKKOS_INLINE_FUNCTION bool add(Index n, const Sum& more) {
    int mine = own;
    for (int k = 0; k < own && place(k) < count && mine == own; ++k)
      if (node[k] == n) mine = k;
    if (!any_of_lanes(mine < own)) {
      if (count == room) return false;
      for (int k = 0; k < own; ++k) {
        if (place(k) != count) continue;
        mine = k;
        node[k] = n;
        sum[k] = Sum{};
      }
      ++count;
    }
    for (int k = 0; k < own; ++k)
      if (k == mine) sum[k] += more;
    return true;
  }
};
struct Nothing {
  KOKKOS_INLINE_FUNCTION Nothing& operator+=(const Nothing&) { return *this; }
};
/// What the corners of a triangle have of its samples, 1/m.
struct AtCorners {
  Real3 corner[3];
  KOKKOS_INLINE_FUNCTION AtCorners& operator+=(const AtCorners& o) {
    for (int c = 0; c < 3; ++c) corner[c] += o.corner[c];
    return *this;
  }
};

/// Visits the samples near a particle, a triangle after the other: most of a triangle's samples stand together.
struct SheetPairs {
  Kernel kernel;
  Neighbors near;
  Entries<const Real4> position, xs, offset;  // x_i and V_i; x_b and V_b; ½ d n_b
  Entries<const Real> ratio, weight;
  Entries<const Index> node, triangle;
  Real rest_density;

  /// Σ_b w_bn g over the row's lanes whose sample b lies in triangle t.
  KOKKOS_INLINE_FUNCTION AtCorners part_of(bool mine, Index b, const Real3& g) const {
    AtCorners part;
    if (mine)
      for (int c = 0; c < 3; ++c) part.corner[c] = weight(3 * b + c) * g;
    return sum_of_lanes(part);
  }
  /// The gradient of sample b at x, 1/m.
  KOKKOS_INLINE_FUNCTION Real3 gradient(const Real3& x, Real scale, Index b) const {
    const Real4 at = xs(b);
    return (scale * at.w) * kernel.gradient(from_behind(x - at.xyz(), offset(b).xyz()));
  }
  /// How many pairs with nodes it has.
  KOKKOS_INLINE_FUNCTION Index count(Index i, Index lane) const {
    const NeighborRow row = near.row(i);
    NodeTable<Nothing> table(lane);
    Index single = 0, here = -1;
    for (Index first = 0; first < row.count; first += row_lanes) {
      const Index b = first + lane < row.count ? row(first + lane) : -1;
      Index of = b >= 0 ? triangle(b) : -1;
      for (Index next = first_lane(of >= 0); next < row_lanes; next = first_lane(of >= 0)) {
        const Index t = of_lane(next, of), sample = of_lane(next, b);
        if (of == t) of = -1;
        if (t == here) continue;
        here = t;
        for (int c = 0; c < 3; ++c) single += table.add(node(3 * sample + c), {}) ? 0 : 1;
      }
    }
    return table.count + single;
  }
  /// write(place in the row, node, p_in) for each of them.
  template <class Write>
  KOKKOS_INLINE_FUNCTION void visit(Index i, Index lane, const Write& write) const {
    const NeighborRow row = near.row(i);
    if (row.count == 0) return;
    NodeTable<Real3> table(lane);
    Index single = 0, here = -1, corner[3];
    AtCorners part;
    const auto take = [&] {
      for (int c = 0; c < 3; ++c) {
        if (table.add(corner[c], part.corner[c])) continue;
        if (lane == 0) write(table.room + single, corner[c], part.corner[c]);
        ++single;
      }
    };
    const Real scale = mirrored * image_density(ratio(i));
    const Real3 x = position(i).xyz();
    for (Index first = 0; first < row.count; first += row_lanes) {
      const Index b = first + lane < row.count ? row(first + lane) : -1;
      Index of = b >= 0 ? triangle(b) : -1;
      const Real3 g = b >= 0 ? gradient(x, scale, b) : Real3{};
      for (Index next = first_lane(of >= 0); next < row_lanes; next = first_lane(of >= 0)) {
        const Index t = of_lane(next, of), sample = of_lane(next, b);
        if (t != here) {
          if (here >= 0) take();
          here = t;
          part = {};
          for (int c = 0; c < 3; ++c) corner[c] = node(3 * sample + c);
        }
        part += part_of(of == t, b, g);
        if (of == t) of = -1;
      }
    }
    take();
    for (int k = 0; k < table.own; ++k)
      if (table.place(k) < table.count) write(table.place(k), table.node[k], table.sum[k]);
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
Index count_pairs(const SheetPairs& pairs, NeighborLists& lists) {
  SheetRows& rows = lists.sheet_rows;
  const Index particles = lists.fluid_sample.rows;
  const Entries<Index> start = rows.of_particle;
  Kokkos::deep_copy(ExecSpace(), Kokkos::subview(rows.of_particle, std::pair(Index{0}, particles + 1)), Index{0});
  parallel_filled_rows(
      "drench::sheet_rows::count", lists.fluid_sample, lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const Index count = pairs.count(i, lane);
        if (lane == 0) start(i) = count;
      });
  rows.sums.sum(rows.of_particle, particles + 1);
  Index all = 0;
  Kokkos::deep_copy(all, Kokkos::subview(rows.of_particle, particles));
  return all;
}

void write_pairs(const SheetPairs& pairs, NeighborLists& lists) {
  SheetRows& rows = lists.sheet_rows;
  const Entries<const Index> start = rows.of_particle;
  const Entries<SheetPair> pair = rows.particle_pair;
  const Entries<Index> owner = rows.owner, item = rows.sort.item;
  const Entries<PairSort::Key> key = rows.sort.key;
  parallel_filled_rows(
      "drench::sheet_rows::pairs", lists.fluid_sample, lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const Index first = start(i);
        pairs.visit(i, lane, [&](const Index place, const Index n, const Real3& gradient) {
          const Index e = first + place;
          pair(e) = {gradient, n};
          item(e) = e;
          owner(e) = i;
          key(e) = static_cast<PairSort::Key>(n);
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
  const Index particles = fluid.particles.count, nodes = cloth.nodes.count;
  make_row_room(rows, particles, nodes);
  const SheetPairs pairs{constants.kernel,
                         Neighbors(lists.fluid_sample),
                         fluid.position_volume,
                         cloth.samples.position_volume,
                         cloth.samples.normal_offset,
                         fluid.particles.density_ratio,
                         cloth.samples.weight,
                         cloth.samples.node,
                         cloth.samples.triangle,
                         constants.rest_density};
  rows.count = count_pairs(pairs, lists);
  if (rows.count == 0) return;
  make_pair_room(rows, rows.count);
  write_pairs(pairs, lists);
  turn(pairs, rows, nodes);
}

double sheet_row_bytes(const Sizing& s) {
  // Of a particle with m samples, q of which share a node: the nodes of the triangles that they lie in.
  const double m = 10, q = std::max(1.0, s.size.samples / std::max(1.0, s.size.nodes));
  const double share = std::min(3.0, 1 / q + 1.3 / std::sqrt(m * q) + 3 / m);
  const double pairs = share * s.entries.fluid_sample;
  return room_for_entries(pairs) * (8 * s.real + 5 * index_bytes) +
         (1.25 * s.size.fluid + s.size.nodes) * index_bytes;
}

}  // namespace drench::kokkos_backend
