// Stage neighbors (src/stages/neighbors.hpp).

#include "laws/rim.hpp"
#include "primitives/neighbor_list.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// Whether the sheet at sample p, at xp with normal n, is between xi and xj.
KOKKOS_INLINE_FUNCTION bool sheet_between(const Real3& xi, const Real3& xj, const Real3& xp, const Real3& n, Real limit,
                                          const Rims& rims, Index p) {
  const Real3 ri = xi - xp, rj = xj - xp;
  const Real si = dot(ri, n), sj = dot(rj, n);
  if ((si < 0) == (sj < 0)) return false;
  const Real3 c = ri + (si / (si - sj)) * (rj - ri);
  return rims.on_sheet(p, xp, c, limit);
}

/// Takes out of fluid_fluid the pairs on different sides of a cloth.
void part_by_cloth(Device& d) {
  const Index n = d.fluid.count;
  auto& nearest_sample = d.work.nearest_sample;
  if (static_cast<Index>(nearest_sample.extent(0)) < n)
    nearest_sample = Array<Index>(Kokkos::ViewAllocateWithoutInitializing("drench::nearest_sample"), n + n / 4);
  const auto nearest = nearest_sample;
  const auto x = d.fluid.position, xs = d.samples.position, normal = d.samples.normal;
  const Neighbors samples(d.fluid_sample), list(d.fluid_fluid);
  parallel(
      "drench::neighbors::nearest_sample", n, KOKKOS_LAMBDA(const Index i) {
        Index best = -1;
        Real least = 0;
        const NeighborRow near = samples.row(i);
        for (Index k = 0; k < near.count; ++k) {
          const Real3 r = x(i) - xs(near(k));
          const Real r2 = dot(r, r);
          if (best >= 0 && r2 >= least) continue;
          best = near(k);
          least = r2;
        }
        nearest(i) = best;
      });
  const Rims rims{d.samples.rim, d.mesh.rim, d.nodes.position};
  const Real reach = Real(1.25) * d.spacing, limit = reach * reach;
  parallel(
      "drench::neighbors::part_by_cloth", n, KOKKOS_LAMBDA(const Index i) {
        const NeighborRow near = list.row(i);
        const Index p = nearest(i);
        // Most rows end here, after loads that do not wait for each other.
        Index any = p;
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index q = nearest(near(k));
          any = q > any ? q : any;
        }
        if (any < 0) return;
        Index kept = 0;
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k), q = nearest(j);
          // Both tests see their own end first, so that i and j come to the same answer.
          if (p >= 0 && sheet_between(x(i), x(j), xs(p), normal(p), limit, rims, p)) continue;
          if (q >= 0 && sheet_between(x(j), x(i), xs(q), normal(q), limit, rims, q)) continue;
          if (kept < k) near(kept) = j;
          ++kept;
        }
        list.count(i) = kept;
      });
}

}  // namespace

void neighbors(Device& d, const StepInfo&, StepReport&) {
  const Real h = d.support;
  d.fluid_cells.build(d.fluid.position, d.fluid.count, h, d.fluid.id, d.measured.fresh ? &d.measured.fluid : nullptr);
  d.order_fluid_by_cell();
  std::vector<ListRequest> lists{{&d.fluid_fluid, d.fluid.position, d.fluid.count, d.fluid_cells.view(), true, true}};
  if (d.boundary.count > 0) {
    if (d.model.has_moving_body() || d.boundary_cells.view().buckets == 0)
      d.boundary_cells.build(d.boundary.position, d.boundary.count, h);
    lists.push_back({&d.fluid_boundary, d.fluid.position, d.fluid.count, d.boundary_cells.view()});
    list_body_neighbors(d);
  }
  if (d.samples.count > 0) {
    // Stage porous_neighbors has left these where the samples still are.
    place_samples(d);
    refresh_sample_cells(d);
    lists.push_back({&d.fluid_sample, d.fluid.position, d.fluid.count, d.sample_cells.view()});
    lists.push_back({&d.sample_fluid, d.samples.position, d.samples.count, d.fluid_cells.view()});
    if (!d.sample_list_fresh)
      lists.push_back({&d.sample_sample, d.samples.position, d.samples.count, d.sample_cells.view(), true});
    d.sample_list_fresh = true;
  }
  build_neighbor_lists(lists, h);
  if (d.samples.count > 0 && !d.model.scene.through_cloth) part_by_cloth(d);
}

}  // namespace drench::kokkos_backend
