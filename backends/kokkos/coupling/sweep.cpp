// Stage advection (law: src/stages/advection.hpp), law 3: paths. What may hit is decided in single precision with room
// for rounding, what does hit in double. On a GPU kernels of their own do each: few particles hit, and a warp would
// wait for each of them.

#include "coupling/sweep.hpp"

#include <cmath>

#include "core/filled_rows.hpp"
#include "core/host_copy.hpp"
#include "core/z_curve.hpp"
#include "coupling/collision.hpp"
#include "coupling/collision_filter.hpp"

namespace drench::kokkos_backend {
namespace {

/// Who looks at a particle: lanes of a warp that go through the same tests, each with its share of what is near.
template <Index lanes>
struct Lanes {
  static constexpr Index count = lanes;
  Index lane;

  /// The earliest of all lanes' hits, in all of them.
  KOKKOS_INLINE_FUNCTION Hit earliest(Hit hit) const {
    for (int apart = count / 2; apart > 0; apart /= 2) {
      const Hit other = of_other_lane<count>(hit, apart);
      if (other.before(hit)) hit = other;
    }
    return hit;
  }
};
using Alone = Lanes<1>;
using LanesOfRow = Lanes<row_lanes>;
using LanesOfWarp = Lanes<on_host ? 1 : warp_size>;  // few particles hit, and some of them many times

constexpr int max_slides = 3, max_carries = 3, max_squeezes = 6, max_repeats = max_slides + max_carries + max_squeezes;

/// A particle's path, m.
struct Path {
  Real3 x0, x1;
  Box box;

  KOKKOS_INLINE_FUNCTION Path(const Real3& from, const Real3& to) : x0(from), x1(to) {
    box.lo = {smaller(x0.x, x1.x), smaller(x0.y, x1.y), smaller(x0.z, x1.z)};
    box.hi = {larger(x0.x, x1.x), larger(x0.y, x1.y), larger(x0.z, x1.z)};
  }
};

constexpr Index cluster_width = 32;  // triangles of a cluster, clusters of a group

/// Paths and the triangles near them. The samples are where they were at the start, as their table has them.
struct Sweep {
  CellTableView cells;  // of the samples; not used with clusters
  Neighbors list;       // fluid→sample, from the step's start
  Entries<const Real3> start, end;
  Entries<const Index> sample_triangle, triangle;
  Entries<Box> box;  // of each triangle's way
  Entries<const Index> ordered;
  Entries<Box> cluster_box;
  Index clusters = 0, groups = 0;  // 0: none
  Index samples = 0;
  Kokkos::View<ClothMotion, MemSpace> motion;
  double cover = 0, margin = 0, touch = 0, support = 0, gap = 0;  // m
  bool listed = false;                                            // are the particles those of the list?
  // of each particle, and the nodes' hits
  Entries<Real3> path_end, hit_weight, hit_normal;
  Entries<Index> hit_triangle, hits;
  Entries<const std::int64_t> id;
  Tunnelled* tunnelled = nullptr;

  explicit Sweep(const NeighborLists& lists) : list(lists.fluid_sample) {}

  KOKKOS_INLINE_FUNCTION Corners corners(const Entries<const Real3>& x, Index t) const {
    return {widen(x(triangle(3 * t))), widen(x(triangle(3 * t + 1))), widen(x(triangle(3 * t + 2)))};
  }

  /// May a triangle be hit whose box is not apart from the path's?
  KOKKOS_INLINE_FUNCTION bool may_hit(const Path& path, Index t) const {
    const Index a = triangle(3 * t), b = triangle(3 * t + 1), c = triangle(3 * t + 2);
    const Real3 from[3] = {start(a), start(b), start(c)}, to[3] = {end(a), end(b), end(c)};
    const RelativeWay way(path.x0, path.x1, from, to);
    return !passes_by(way, Real(margin)) && !stays_on_its_side(way, Real(touch));
  }

  /// Where what a path can hit was at the start, relative to x0, and how far from samples.
  struct Reach {
    Double3 lo, hi;
    double grow;
    bool listed;  // does the list have all samples there?
  };
  KOKKOS_INLINE_FUNCTION Reach reach_of(const Path& path) const {
    const ClothMotion moved = motion();
    const Double3 x0 = widen(path.x0), way = minus(widen(path.x1), x0);
    const double grow = cover * larger(1.0, moved.stretch) + margin;
    // τ (way − its displacement)
    const Double3 lo{smaller(0.0, way.x - moved.most.x), smaller(0.0, way.y - moved.most.y),
                     smaller(0.0, way.z - moved.most.z)};
    const Double3 hi{larger(0.0, way.x - moved.least.x), larger(0.0, way.y - moved.least.y),
                     larger(0.0, way.z - moved.least.z)};
    const Double3 most{larger(-lo.x, hi.x), larger(-lo.y, hi.y), larger(-lo.z, hi.z)};
    return {lo, hi, grow, listed && Kokkos::sqrt(inner(most, most)) + grow < support};
  }

  /// May there be cloth near the path that the list does not have?
  KOKKOS_INLINE_FUNCTION bool has_cloth_out_of_list(const Path& path) const {
    const Reach reach = reach_of(path);
    if (reach.listed) return false;
    if (clusters > 0) return true;
    const Box box = box_of(path, reach);
    CellCoord a = cells.cell_of(box.lo), b = cells.cell_of(box.hi);
    cells.clip(a, b);
    return a.x <= b.x && a.y <= b.y && a.z <= b.z;
  }
  /// Visits the triangle of each sample near the path, if its box is: each that can be hit, some of them often. Cloth
  /// that collides with itself may be stretched too far for samples: then the triangles of clusters whose boxes are
  /// near.
  template <class Who, class Visitor>
  KOKKOS_INLINE_FUNCTION void visit_near(Index i, const Path& path, const Who& who, Visitor& visitor) const {
    const Reach reach = reach_of(path);
    if (reach.listed) {
      // Rows in folds have hundreds of samples: some at once, whose loads do not wait for each other.
      constexpr Index lot = on_host ? 1 : 4;
      const NeighborRow near = list.row(i);
      for (Index first = who.lane; first < near.count; first += lot * Who::count) {
        Index candidate[lot];
        bool meets[lot];
        const auto entry = [&](Index k) { return first + k * Who::count; };
        for (Index k = 0; k < lot; ++k) candidate[k] = sample_triangle(near(entry(k) < near.count ? entry(k) : first));
        for (Index k = 0; k < lot; ++k) meets[k] = entry(k) < near.count && !path.box.apart(box(candidate[k]));
        for (Index k = 0; k < lot; ++k)
          if (meets[k]) visitor(candidate[k]);
      }
      return;
    }
    if (clusters > 0) {
      visit_clusters(path, who, visitor);
      return;
    }
    const Box box = box_of(path, reach);
    visit_cells(box.lo, box.hi, path, who, visitor);
  }
  /// Where samples were at the start whose triangles a path can hit.
  KOKKOS_INLINE_FUNCTION static Box box_of(const Path& path, const Reach& reach) {
    const Double3 x0 = widen(path.x0), grow{reach.grow, reach.grow, reach.grow};
    return {narrow(minus(add(x0, reach.lo), grow)), narrow(add(add(x0, reach.hi), grow))};
  }
  template <class Who, class Visitor>
  KOKKOS_INLINE_FUNCTION void visit_cells(const Real3& least_point, const Real3& most_point, const Path& path,
                                          const Who& who, Visitor& visitor) const {
    const auto visit = [&](const Index entry) {
      const Real3 p = cells.point(entry);
      if (p.x < least_point.x || p.y < least_point.y || p.z < least_point.z || p.x > most_point.x ||
          p.y > most_point.y || p.z > most_point.z)
        return;
      const Index t = sample_triangle(cells.item(entry));
      if (!path.box.apart(box(t))) visitor(t);
    };
    CellCoord a = cells.cell_of(least_point), b = cells.cell_of(most_point);
    // A runaway particle may sweep more cells than there are samples.
    const double box_cells = (double(b.x) - a.x + 1) * (double(b.y) - a.y + 1) * (double(b.z) - a.z + 1);
    if (box_cells <= static_cast<double>(samples)) {
      cells.clip(a, b);
      cells.for_runs(a, b, [&](const Index first, const Index end_of_run, const CellRun& run) {
        for (Index e = first + who.lane; e < end_of_run; e += Who::count)
          if (!cells.hashed || run.holds(cells.coord(e))) visit(e);
      });
    } else {
      for (Index e = who.lane; e < samples; e += Who::count) visit(e);
    }
  }
  template <class Who, class Visitor>
  KOKKOS_INLINE_FUNCTION void visit_clusters(const Path& path, const Who& who, Visitor& visitor) const {
    for (Index group = 0; group < groups; ++group) {
      if (path.box.apart(cluster_box(clusters + group))) continue;
      for (Index c = cluster_width * group; c < cluster_width * (group + 1); ++c) {
        if (path.box.apart(cluster_box(c))) continue;
        for (Index k = cluster_width * c + who.lane; k < cluster_width * (c + 1); k += Who::count) {
          const Index t = ordered(k);
          if (t >= 0 && !path.box.apart(box(t))) visitor(t);
        }
      }
    }
  }

  /// Is there a triangle that may be hit? A triangle's test is skipped if it was one of the last two.
  struct Look {
    const Sweep& sweep;
    const Path& path;
    bool found = false;
    Index last = -1, before = -1;

    KOKKOS_INLINE_FUNCTION void operator()(Index t) {
      if (found) return;
      if (t == last || t == before) return;
      before = last;
      last = t;
      found = sweep.may_hit(path, t);
    }
  };

  /// Collects triangles that may be hit and tests some at once, so that the threads of a warp do that together.
  struct Test {
    static constexpr int room = 6;
    const Sweep& sweep;
    const Path& path;
    Hit best;
    Index last = -1, before = -1;
    int count = 0;
    Index found[room];

    KOKKOS_INLINE_FUNCTION Test(const Sweep& s, const Path& p) : sweep(s), path(p) {}
    KOKKOS_INLINE_FUNCTION void operator()(Index t) {
      if (t == last || t == before) return;
      before = last;
      last = t;
      for (int k = 0; k < count; ++k)
        if (found[k] == t) return;
      if (!sweep.may_hit(path, t)) return;
      if (count == room) finish();
      found[count++] = t;
    }
    KOKKOS_INLINE_FUNCTION void finish() {
      const Double3 x0 = widen(path.x0), x1 = widen(path.x1);
      for (int k = 0; k < count; ++k) {
        const Index t = found[k];
        Hit hit;
        if (!first_hit(x0, x1, sweep.corners(sweep.start, t), sweep.corners(sweep.end, t), sweep.touch, hit)) continue;
        hit.triangle = t;
        if (hit.before(best)) best = hit;
      }
      count = 0;
    }
  };

  /// In any of a row's lanes, which look each at a share.
  template <class Who>
  KOKKOS_INLINE_FUNCTION bool may_hit(Index i, const Path& path, const Who& who) const {
    Look look{*this, path};
    visit_near(i, path, who, look);
    return Who::count == 1 ? look.found : any_of_lanes(look.found);
  }
  template <class Who>
  KOKKOS_INLINE_FUNCTION Hit earliest(Index i, const Path& path, const Who& who) const {
    Test test(*this, path);
    visit_near(i, path, who, test);
    test.finish();
    return who.earliest(test.best);
  }

  KOKKOS_INLINE_FUNCTION void note_crossing(Index i) const {
    Kokkos::atomic_add(&tunnelled->count, std::int64_t{1});
    Kokkos::atomic_min(&tunnelled->lowest, id(i));
  }

  /// Stops particle i, at `from` at the start, where it hits: path_end and hit_* are those of a free path so far.
  template <class Who>
  KOKKOS_INLINE_FUNCTION void stop(Index i, const Real3& from_point, const Who& who) const {
    const Double3 x0 = widen(from_point), free = widen(path_end(i));
    Hit last;
    Real3 to_point = path_end(i);
    Double3 change, normal;  // what the cloth changes of the way
    for (int test = 0; test <= max_repeats; ++test) {
      const Hit hit = earliest(i, Path(from_point, to_point), who);
      if (hit.triangle < 0) break;
      if (test == max_repeats) {  // where it stays on the last triangle it is beyond another one
        if (who.lane == 0) note_crossing(i);
        break;
      }
      last = hit;
      const Corners from = corners(start, hit.triangle), to = corners(end, hit.triangle);
      const double height = inner(minus(x0, from.a), from.normal());
      normal = times(height >= 0 ? 1 : -1, to.normal());
      const Double3 reached = widen(to_point);
      const double above = inner(minus(reached, to.a), normal);
      Double3 target;
      if (test < max_slides && above < gap) {
        target = add(reached, times(gap - above, normal));
      } else {
        double lift = gap, carried[3] = {hit.weight[0], hit.weight[1], hit.weight[2]};
        if (test >= max_slides + max_carries) {  // squeezed: where it was on the last one, or nearer
          lift = larger(gap, Kokkos::abs(height));
          for (int k = max_slides + max_carries; k < test; ++k) lift *= 0.25;
          double foot[3];
          if (barycentric(from, x0, foot))
            for (int a = 0; a < 3; ++a) carried[a] = foot[a];
        }
        target = add(to.at(carried), times(lift, normal));
      }
      change = minus(target, free);
      to_point = narrow(target);  // rounded as it is stored, so that what is tested is what stays
    }
    if (last.triangle < 0 || who.lane > 0) return;
    const double length = Kokkos::sqrt(inner(change, change));
    path_end(i) = to_point;
    hit_triangle(i) = last.triangle;
    hit_weight(i) = {Real(last.weight[0]), Real(last.weight[1]), Real(last.weight[2])};
    hit_normal(i) = narrow(length > 0 ? times(1 / length, change) : normal);
    for (Index k = 0; k < 3; ++k) Kokkos::atomic_add(&hits(triangle(3 * last.triangle + k)), Index{1});
  }
};

/// A box around none.
KOKKOS_INLINE_FUNCTION Box no_box() {
  constexpr Real far = Kokkos::Experimental::finite_max_v<Real>;
  return {{far, far, far}, {-far, -far, -far}};
}
KOKKOS_INLINE_FUNCTION void enclose(Box& box, const Box& o) {
  box.lo = {smaller(box.lo.x, o.lo.x), smaller(box.lo.y, o.lo.y), smaller(box.lo.z, o.lo.z)};
  box.hi = {larger(box.hi.x, o.hi.x), larger(box.hi.y, o.hi.y), larger(box.hi.z, o.hi.z)};
}

/// The boxes of the triangles' ways, of clusters and of groups.
void place_boxes(const Sweep& sweep, Index triangles) {
  const bool ordered = sweep.clusters > 0;
  parallel(
      "drench::advection::boxes", ordered ? sweep.clusters * cluster_width : triangles, KOKKOS_LAMBDA(const Index k) {
        const Index t = ordered ? sweep.ordered(k) : k;
        if (t >= 0) sweep.box(t) = box_of_way(sweep.corners(sweep.start, t), sweep.corners(sweep.end, t), sweep.margin);
      });
  parallel(
      "drench::advection::cluster_boxes", sweep.clusters, KOKKOS_LAMBDA(const Index c) {
        Box box = no_box();
        DRENCH_UNROLL
        for (Index k = cluster_width * c; k < cluster_width * (c + 1); ++k)
          if (sweep.ordered(k) >= 0) enclose(box, sweep.box(sweep.ordered(k)));
        sweep.cluster_box(c) = box;
      });
  parallel(
      "drench::advection::group_boxes", sweep.groups, KOKKOS_LAMBDA(const Index g) {
        Box box = no_box();
        DRENCH_UNROLL
        for (Index c = cluster_width * g; c < cluster_width * (g + 1); ++c) enclose(box, sweep.cluster_box(c));
        sweep.cluster_box(sweep.clusters + g) = box;
      });
}

/// Looks for what particles may hit whose list has all of it.
void look_near(const Fluid& fluid, const NeighborLists& lists, AdvectionWork& work, const Sweep& sweep) {
  const Entries<const Real3> position = fluid.particles.position;
  const Entries<Index> near = work.near;
  const auto near_count = work.near_count;
  parallel_filled_rows(
      "drench::advection::look", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const Path path(position(i), sweep.path_end(i));
        if (!sweep.reach_of(path).listed || !sweep.may_hit(i, path, LanesOfRow{lane}) || lane > 0) return;
        near(Kokkos::atomic_fetch_add(&near_count(), Index{1})) = i;
      });
}

/// The same of the particles whose list lacks some of it. Where cloth is stretched, many samples are then near.
void look_far(const Fluid& fluid, AdvectionWork& work, const Sweep& sweep) {
  const Entries<const Real3> position = fluid.particles.position;
  const Entries<Index> near = work.near;
  const Entries<const Index> far = std::as_const(work).far;
  const auto near_count = work.near_count, far_count = work.far_count;
  const Index groups = smaller(fluid.particles.count, rows_at_once);
  parallel(
      "drench::advection::look_far", groups * row_lanes, KOKKOS_LAMBDA(const Index thread) {
        for (Index k = thread / row_lanes; k < far_count(); k += groups) {
          const Index i = far(k), lane = thread % row_lanes;
          if (!sweep.may_hit(i, Path(position(i), sweep.path_end(i)), LanesOfRow{lane}) || lane > 0) continue;
          near(Kokkos::atomic_fetch_add(&near_count(), Index{1})) = i;
        }
      });
}

/// Stops the particles that kernels look and look_far have found.
void stop_near(const Fluid& fluid, const AdvectionWork& work, const Sweep& sweep) {
  const Entries<const Real3> position = fluid.particles.position;
  const Entries<const Index> near = work.near;
  const auto near_count = work.near_count;
  constexpr Index lanes = LanesOfWarp::count;
  const Index groups = (fluid.particles.count + lanes - 1) / lanes;
  parallel(
      "drench::advection::stop", groups * lanes, KOKKOS_LAMBDA(const Index thread) {
        for (Index k = thread / lanes; k < near_count(); k += groups)
          sweep.stop(near(k), position(near(k)), LanesOfWarp{thread % lanes});
      });
}

Sweep sweep_of(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
               AdvectionWork& work) {
  Sweep sweep(lists);
  sweep.cells = cloth.sample_cells.view();
  sweep.samples = cloth.samples.count;
  sweep.start = constants.model.has_moving_cloth() ? std::as_const(work).start : cloth.nodes.position;
  sweep.end = cloth.nodes.position;
  sweep.sample_triangle = cloth.samples.triangle;
  sweep.triangle = cloth.mesh.triangle;
  sweep.motion = work.motion;
  sweep.cover = constants.model.samples.cover_radius;
  sweep.margin = 1e-3 * constants.model.spacing;
  sweep.touch = 1e-6 * constants.model.spacing;
  sweep.gap = 1e-2 * constants.model.spacing;
  sweep.support = 0.999 * constants.support;  // the list's distances are rounded
  sweep.listed = lists.fluid_sample.rows == fluid.particles.local();
  sweep.box = work.box;
  sweep.ordered = work.ordered;
  sweep.cluster_box = work.cluster_box;
  sweep.clusters = static_cast<Index>(work.ordered.extent(0)) / cluster_width;
  sweep.groups = sweep.clusters / cluster_width;
  sweep.path_end = work.end;
  sweep.hit_weight = work.hit_weight;
  sweep.hit_normal = work.hit_normal;
  sweep.hit_triangle = work.hit_triangle;
  sweep.hits = work.hits;
  sweep.id = fluid.particles.id;
  sweep.tunnelled = fluid.tunnelled.data();
  return sweep;
}

}  // namespace

void order_triangles(const Constants& constants, AdvectionWork& work) {
  const ClothMesh& mesh = constants.model.mesh;
  if (work.ordered.exists() || mesh.triangle.empty() || !constants.model.has_self_collision()) return;
  std::vector<Vec3> middle;
  double length = 0;
  for (const auto& t : mesh.triangle) {
    const auto at = [&](std::size_t k) { return mesh.rest_position[static_cast<std::size_t>(t[k])]; };
    const Vec3 a = at(0), b = at(1), c = at(2);
    middle.push_back({(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3, (a[2] + b[2] + c[2]) / 3});
    length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / static_cast<double>(mesh.triangle.size());
  }
  std::vector<Index> order = along_z_curve(middle, mesh.triangle_cloth, length);
  constexpr std::size_t group = cluster_width * cluster_width;
  order.resize((order.size() + group - 1) / group * group, -1);
  work.ordered = to_device<Index>("drench::advection::ordered", order);
  make_room(work.cluster_box, "drench::advection::cluster_box", order.size() / cluster_width + order.size() / group);
}

void sweep_paths(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                 AdvectionWork& work, Real dt) {
  const Sweep sweep = sweep_of(constants, fluid, lists, cloth, work);
  place_boxes(sweep, cloth.mesh.triangles);
  const Entries<const Real3> position = fluid.particles.position, velocity = fluid.particles.velocity,
                             shift = fluid.separation;
  const Entries<Index> far = work.far;
  const auto far_count = work.far_count;
  parallel(
      "drench::advection::sweep", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 x0 = position(i), x1 = x0 + dt * velocity(i) + shift(i);
        const Path path(x0, x1);
        sweep.path_end(i) = x1;
        sweep.hit_triangle(i) = -1;
        if (on_host) {
          if (sweep.may_hit(i, path, Alone{0})) sweep.stop(i, x0, Alone{0});
        } else if (sweep.has_cloth_out_of_list(path)) {
          far(Kokkos::atomic_fetch_add(&far_count(), Index{1})) = i;
        }
      });
  if (on_host) return;
  look_far(fluid, work, sweep);
  look_near(fluid, lists, work, sweep);
  stop_near(fluid, work, sweep);
}

void check_put_back(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                    AdvectionWork& work) {
  const Sweep sweep = sweep_of(constants, fluid, lists, cloth, work);
  const Entries<const Real3> position = fluid.particles.position;
  parallel_filled_rows(
      "drench::advection::put_back", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const Path path(sweep.path_end(i), position(i));
        const Real3 way = path.x1 - path.x0;
        if (!(dot(way, way) > 0)) return;
        const NeighborRow near = sweep.list.row(i);
        bool crossed = false;
        for (Index k = lane; k < near.count && !crossed; k += row_lanes) {
          const Index t = sweep.sample_triangle(near(k));
          if (path.box.apart(sweep.box(t))) continue;
          const Corners there = sweep.corners(sweep.end, t);
          Hit hit;
          crossed = first_hit(widen(path.x0), widen(path.x1), there, there, 0, hit);
        }
        if (any_of_lanes(crossed) && lane == 0) sweep.note_crossing(i);
      });
}

}  // namespace drench::kokkos_backend
