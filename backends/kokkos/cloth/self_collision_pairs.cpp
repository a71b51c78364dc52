// Pairs of the cloth with itself that can come near in a step, by the cell table (src/stages/self_collision.hpp).

#include "cloth/proximity.hpp"
#include "core/gather.hpp"
#include "cloth/self_collision.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index few_changed = 4;  // changed nodes are few if they are at most one in so many

/// Box around a primitive's path.
struct Box3 {
  Double3 lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  KOKKOS_INLINE_FUNCTION void add_point(const Double3& p) {
    lo = {Kokkos::fmin(lo.x, p.x), Kokkos::fmin(lo.y, p.y), Kokkos::fmin(lo.z, p.z)};
    hi = {Kokkos::fmax(hi.x, p.x), Kokkos::fmax(hi.y, p.y), Kokkos::fmax(hi.z, p.z)};
  }
  KOKKOS_INLINE_FUNCTION Double3 center() const { return times(0.5, add(lo, hi)); }
  KOKKOS_INLINE_FUNCTION double half() const {
    return 0.5 * Kokkos::fmax(Kokkos::fmax(hi.x - lo.x, hi.y - lo.y), hi.z - lo.z);
  }
  KOKKOS_INLINE_FUNCTION double farthest() const {
    return Kokkos::fmax(Kokkos::fmax(Kokkos::fmax(Kokkos::abs(lo.x), Kokkos::abs(hi.x)),
                                     Kokkos::fmax(Kokkos::abs(lo.y), Kokkos::abs(hi.y))),
                        Kokkos::fmax(Kokkos::abs(lo.z), Kokkos::abs(hi.z)));
  }
};

/// A box that is compared with many.
struct Window {
  Real3 lo, hi;
  KOKKOS_INLINE_FUNCTION Window(const Box3& box, double reach)
      : lo(narrow(minus(box.lo, {reach, reach, reach}))), hi(narrow(add(box.hi, {reach, reach, reach}))) {}
  KOKKOS_INLINE_FUNCTION bool meets(const Real3& from, const Real3& to) const {
    return from.x <= hi.x && lo.x <= to.x && from.y <= hi.y && lo.y <= to.y && from.z <= hi.z && lo.z <= to.z;
  }
};

/// What the search sees, and where it puts the pairs.
struct Search {
  Entries<const Real3> position;
  Entries<Real3> seen;
  Entries<const Index> node, triangle, edge;
  Entries<Index> pair;
  Entries<Real3> node_lo, node_hi, edge_lo, edge_hi;  // the paths' boxes, rounded
  Materials materials;
  Slice<double> distance, thickness_of;
  Kokkos::View<Index, MemSpace> count;
  CellTableView cells;
  Slice<std::uint8_t> changed, marked;  // SelfCollisionWork
  double margin = 0, reach = 0;         // m
  Index capacity = 0;
  bool all = true;  // or only pairs with a node that has changed?

  KOKKOS_INLINE_FUNCTION Box3 path(const Entries<const Index>& list, Index item, int corners) const {
    Box3 box;
    for (int k = 0; k < corners; ++k) {
      const Index n = list(corners * item + k);
      box.add_point(widen(position(n)));
      box.add_point(widen(seen(n)));
    }
    return box;
  }
  KOKKOS_INLINE_FUNCTION bool any_changed(const Entries<const Index>& list, Index item, int corners) const {
    bool any = false;
    for (int k = 0; k < corners; ++k) any = any || changed(list(corners * item + k)) != 0;
    return any;
  }
  /// Calls visit(item) for what lies in the cells around a box, a lane's share of it.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void visit_around(const Box3& box, double grow, Index lane, const Visit& visit) const {
    const Window around(box, grow);
    CellCoord lo = cells.cell_of(around.lo), hi = cells.cell_of(around.hi);
    cells.clip(lo, hi);
    cells.for_runs(lo, hi, [&](const Index first, const Index last, const CellRun& run) {
      for (Index e = first + lane; e < last; e += row_lanes)
        if (!cells.hashed || run.holds(cells.coord(e))) visit(cells.item(e));
    });
  }
  /// The same in the marked cells alone.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void visit_marked(const Box3& box, double grow, Index lane, const Visit& visit) const {
    const Window around(box, grow);
    CellCoord lo = cells.cell_of(around.lo), hi = cells.cell_of(around.hi);
    cells.clip(lo, hi);
    for (int z = lo.z; z <= hi.z; ++z)
      for (int y = lo.y; y <= hi.y; ++y)
        for (int x = lo.x; x <= hi.x; ++x) {
          const CellCoord cell{x, y, z};
          const Index b = cells.bucket_of(cell);
          if (!marked(b)) continue;
          for (Index e = cells.start(b) + lane; e < cells.start(b + 1); e += row_lanes)
            if (!cells.hashed || cells.coord(e) == cell) visit(cells.item(e));
        }
  }
  /// The pair of four nodes, if it can come nearer than τ.
  KOKKOS_INLINE_FUNCTION void consider(const Index* n, bool edges) const {
    Double3 x[4], u[4];
    for (int k = 0; k < 4; ++k) {
      x[k] = widen(position(n[k]));
      u[k] = minus(widen(seen(n[k])), x[k]);
    }
    const double tau = 0.5 * (double(materials(n[0]).thickness) + double(materials(n[3]).thickness));
    // Every displacement, and with it their mean, may still change by the margin.
    const double delta = proximity(edges, x).distance;
    if (delta - relative_travel(edges, u) - 4 * margin > tau) return;
    const Index at = Kokkos::atomic_fetch_add(&count(), Index{1});
    if (at >= capacity) return;
    for (int k = 0; k < 4; ++k) pair(5 * at + k) = n[k];
    pair(5 * at + 4) = edges ? pair_of_edges : pair_of_node;
    distance(at) = delta;
    thickness_of(at) = tau;
  }
};

struct NodeVisitor {
  const Search& search;
  Window window;
  Index corner[3];
  bool all;  // or only nodes that have changed?
  KOKKOS_INLINE_FUNCTION void operator()(Index item) const {
    const Index n = search.node(item);
    if (!window.meets(search.node_lo(item), search.node_hi(item))) return;
    if (n == corner[0] || n == corner[1] || n == corner[2]) return;
    if (!all && search.changed(n) == 0) return;
    const Index nodes[4] = {n, corner[0], corner[1], corner[2]};
    search.consider(nodes, false);
  }
};

struct EdgeVisitor {
  const Search& search;
  Window window;
  Index self, a, b;
  KOKKOS_INLINE_FUNCTION void operator()(Index item) const {
    if ((item <= self && search.all) || !window.meets(search.edge_lo(item), search.edge_hi(item))) return;
    const Index c = search.edge(2 * item), e = search.edge(2 * item + 1);
    if (c == a || c == b || e == a || e == b) return;
    if (item > self) {
      const Index nodes[4] = {a, b, c, e};
      search.consider(nodes, true);
    } else if (!search.any_changed(search.edge, item, 2)) {  // else the other edge finds the pair
      const Index nodes[4] = {c, e, a, b};
      search.consider(nodes, true);
    }
  }
};

struct Sizes {
  double half_node = 0, half_edge = 0, farthest = 0;  // m
};

/// Centres of the paths of nodes and edges, and how far these reach from them.
Sizes center_paths(const Search& s, SelfCollisionWork& w) {
  const Entries<Real3> node_center = w.node_center, edge_center = w.edge_center;
  Sizes sizes;
  Kokkos::parallel_reduce(
      "drench::self_collision::node_paths", range(w.nodes),
      KOKKOS_LAMBDA(const Index i, double& half, double& far) {
        const Box3 box = s.path(s.node, i, 1);
        node_center(i) = narrow(box.center());
        s.node_lo(i) = narrow(box.lo);
        s.node_hi(i) = narrow(box.hi);
        half = Kokkos::fmax(half, box.half());
        far = Kokkos::fmax(far, box.farthest());
      },
      Kokkos::Max<double>(sizes.half_node), Kokkos::Max<double>(sizes.farthest));
  Kokkos::parallel_reduce(
      "drench::self_collision::edge_paths", range(w.edges),
      KOKKOS_LAMBDA(const Index i, double& half) {
        const Box3 box = s.path(s.edge, i, 2);
        edge_center(i) = narrow(box.center());
        s.edge_lo(i) = narrow(box.lo);
        s.edge_hi(i) = narrow(box.hi);
        half = Kokkos::fmax(half, box.half());
      },
      Kokkos::Max<double>(sizes.half_edge));
  return sizes;
}

void search_nodes(const Search& s, Index triangles, double grow) {
  parallel(
      "drench::self_collision::nodes_at_triangles", triangles * row_lanes, KOKKOS_LAMBDA(const Index thread) {
        const Index t = thread / row_lanes;
        const Box3 box = s.path(s.triangle, t, 3);
        const NodeVisitor visit{s,
                                Window(box, s.reach),
                                {s.triangle(3 * t), s.triangle(3 * t + 1), s.triangle(3 * t + 2)},
                                s.all || s.any_changed(s.triangle, t, 3)};
        if (visit.all)
          s.visit_around(box, grow, thread % row_lanes, visit);
        else
          s.visit_marked(box, grow, thread % row_lanes, visit);
      });
}

/// Marks the cells in which nodes have changed.
void mark_cells(SelfCollisionWork& w, const CellTableView& cells) {
  const auto buckets = static_cast<std::size_t>(cells.buckets);
  if (w.marked.extent(0) < buckets)
    w.marked = Field<std::uint8_t>("drench::self_collision::marked", buckets + buckets / 4);
  else
    Kokkos::deep_copy(ExecSpace(), w.marked, std::uint8_t{0});
  const Entries<std::uint8_t> marked = w.marked;
  const Entries<const std::uint8_t> changed = w.changed;
  const Entries<const Index> node = w.node;
  const Entries<const Real3> center = w.node_center;
  parallel(
      "drench::self_collision::mark", w.nodes, KOKKOS_LAMBDA(const Index i) {
        if (!changed(node(i))) return;
        const Index b = cells.bucket_of(cells.cell_of(center(i)));
        if (b >= 0) Kokkos::atomic_store(&marked(b), std::uint8_t{1});
      });
}

void search_edges(const Search& s, Index edges, double grow) {
  parallel(
      "drench::self_collision::edges_at_edges", edges * row_lanes, KOKKOS_LAMBDA(const Index thread) {
        const Index e = thread / row_lanes;
        if (!s.all && !s.any_changed(s.edge, e, 2)) return;
        const Box3 box = s.path(s.edge, e, 2);
        const EdgeVisitor visit{s, Window(box, s.reach), e, s.edge(2 * e), s.edge(2 * e + 1)};
        s.visit_around(box, grow, thread % row_lanes, visit);
      });
}

void make_room(SelfCollisionWork& w, Index pairs) {
  if (pairs <= static_cast<Index>(w.distance.extent(0))) return;
  const auto n = static_cast<std::size_t>(pairs) + static_cast<std::size_t>(pairs) / 4 + 1024;
  kokkos_backend::make_room(w.pair, "drench::self_collision::pair", 5 * n);
  kokkos_backend::make_room(w.distance, "drench::self_collision::distance", n);
  kokkos_backend::make_room(w.thickness_of, "drench::self_collision::thickness", n);
  kokkos_backend::make_room(w.weight, "drench::self_collision::weight", 4 * n);
  kokkos_backend::make_room(w.normal, "drench::self_collision::normal", 3 * n);
  kokkos_backend::make_room(w.target_gap, "drench::self_collision::target_gap", n);
  kokkos_backend::make_room(w.pair_impulse, "drench::self_collision::pair_impulse", n);
  kokkos_backend::make_room(w.change, "drench::self_collision::change", n);
  kokkos_backend::make_room(w.contact, "drench::self_collision::contact", n);
}

}  // namespace

double close_pair_bytes(const Sizing& s) {
  const double pair = 5 * index_bytes + (2 + 4 + 3 + 3) * double_bytes + 1;
  return (s.size.fold_pairs * s.size.nodes + 1024) * pair;
}

namespace {

/// Adds pairs to those that there are. False: there is no room for them.
bool search(const Cloth& cloth, SelfCollisionWork& work, double margin, bool all) {
  Search s;
  s.position = cloth.nodes.position;
  s.seen = work.seen;
  s.node = work.node;
  s.triangle = work.triangle;
  s.edge = work.edge;
  s.materials = node_materials(cloth);
  s.node_lo = work.node_lo;
  s.node_hi = work.node_hi;
  s.edge_lo = work.edge_lo;
  s.edge_hi = work.edge_hi;
  s.pair = work.pair;
  s.distance = work.distance;
  s.thickness_of = work.thickness_of;
  s.count = work.count;
  s.changed = work.changed;
  s.margin = margin;
  s.capacity = static_cast<Index>(work.distance.extent(0));
  s.all = all;
  const Sizes sizes = center_paths(s, work);
  // Centres and boxes are rounded to the backend's precision.
  const double slack = 1e-6 * Kokkos::fmax(sizes.farthest, double(cloth.mesh.mean_edge));
  s.reach = work.thickness + 2 * margin + slack;
  const double node_reach = s.reach + sizes.half_node, edge_reach = s.reach + sizes.half_edge;
  work.node_cells.build(work.node_center, work.nodes, static_cast<Real>(Kokkos::fmax(double(cloth.mesh.mean_edge), node_reach)));
  work.edge_cells.build(work.edge_center, work.edges, static_cast<Real>(Kokkos::fmax(double(cloth.mesh.mean_edge), edge_reach)));
  s.cells = work.node_cells.view();
  if (!all) mark_cells(work, s.cells);
  s.marked = work.marked;
  search_nodes(s, work.triangles, node_reach);
  s.cells = work.edge_cells.view();
  search_edges(s, work.edges, edge_reach);
  Kokkos::deep_copy(work.pairs, work.count);
  return work.pairs <= s.capacity;
}

/// Which ends have moved by more than `margin` since they were seen: they are seen anew. Returns how many; synchronises with
/// the host.
Index see_changes(const Cloth& cloth, SelfCollisionWork& work, double margin) {
  const Entries<Real3> seen = work.seen;
  const Entries<const Real3> end = work.end;
  const Entries<std::uint8_t> changed = work.changed;
  Index count = 0;
  Kokkos::parallel_reduce(
      "drench::self_collision::moved", range(cloth.nodes.count),
      KOKKOS_LAMBDA(const Index n, Index& sum) {
        const Double3 by = minus(widen(end(n)), widen(seen(n)));
        const bool moved = inner(by, by) > margin * margin;
        changed(n) = moved ? 1 : 0;
        if (!moved) return;
        seen(n) = end(n);
        ++sum;
      },
      count);
  return count;
}

void drop_changed(SelfCollisionWork& w) {
  const Entries<Index> pair = w.pair;
  const Entries<const std::uint8_t> changed = w.changed;
  parallel(
      "drench::self_collision::drop", w.pairs, KOKKOS_LAMBDA(const Index p) {
        bool any = false;
        for (int k = 0; k < 4; ++k) any = any || changed(pair(5 * p + k)) != 0;
        if (any) pair(5 * p + 4) = dropped_pair;
      });
}

}  // namespace

void find_close_pairs(const Cloth& cloth, SelfCollisionWork& work, double margin) {
  make_room(work, 8 * work.nodes);
  Kokkos::deep_copy(ExecSpace(), work.seen, work.end);
  do {
    make_room(work, work.pairs);
    Kokkos::deep_copy(ExecSpace(), work.count, Index{0});
  } while (!search(cloth, work, margin, true));
}

void renew_close_pairs(const Cloth& cloth, SelfCollisionWork& work, double margin) {
  const Index changed = see_changes(cloth, work, margin);
  if (changed == 0) return;
  if (few_changed * changed <= cloth.nodes.count) {
    drop_changed(work);
    if (search(cloth, work, margin, false)) return;
  }
  find_close_pairs(cloth, work, margin);
}

}  // namespace drench::kokkos_backend
