// Stage neighbors (src/stages/neighbors.hpp).

#include "cloth/boundary_edges.hpp"
#include "core/filled_rows.hpp"
#include "core/liquid_pairs.hpp"
#include "core/neighbor_search.hpp"
#include "core/reduce.hpp"
#include "coupling/body_response.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// Whether the sheet at sample p, at xp with normal n, is between xi and xj.
KOKKOS_INLINE_FUNCTION bool sheet_between(const Real3& xi, const Real3& xj, const Real3& xp, const Real3& n, Real limit,
                                          const BoundaryEdges& edges, Index p) {
  const Real3 ri = xi - xp, rj = xj - xp;
  const Real si = dot(ri, n), sj = dot(rj, n);
  if ((si < 0) == (sj < 0)) return false;
  const Real3 c = ri + (si / (si - sj)) * (rj - ri);
  return edges.on_sheet(p, xp, c, limit);
}

/// fluid.nearest_sample: the sample nearest to each particle.
void find_nearest_samples(const NeighborLists& lists, const Cloth& cloth, Fluid& fluid) {
  const Index n = fluid.particles.local();
  make_ample_room(fluid.nearest_sample, "drench::nearest_sample", static_cast<std::size_t>(n));
  const Entries<Index> nearest = fluid.nearest_sample;
  const Entries<const Real3> x = fluid.particles.position, xs = cloth.samples.position;
  const Neighbors samples(lists.fluid_sample);
  parallel(
      "drench::neighbors::nearest_sample", n, KOKKOS_LAMBDA(const Index i) {
        Index best = -1;
        Real least = 0;
        samples.for_each(i, [&](Index b) {
          const Real3 r = x(i) - xs(b);
          const Real r2 = dot(r, r);
          if (best >= 0 && r2 >= least) return;
          best = b;
          least = r2;
        });
        nearest(i) = best;
      });
}

/// fluid.nearest_sample.
double nearest_sample_bytes(const Sizing& s) { return s.size.samples > 0 ? particle_room(s) * index_bytes : 0; }

/// Culls the pairs across a cloth from fluid_fluid.
void cull_pairs_across_cloth(const Constants& constants, const Fluid& fluid, const Cloth& cloth, NeighborLists& lists) {
  const Entries<const Index> nearest = fluid.nearest_sample;
  const Entries<const Real3> x = fluid.particles.position, xs = cloth.samples.position, normal = cloth.samples.normal;
  const WritableLiquidNeighbors list(lists.fluid_fluid);
  const BoundaryEdges edges(cloth);
  const Real reach = Real(1.25) * constants.spacing, limit = reach * reach;
  parallel(
      "drench::neighbors::cull_pairs", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Index p = nearest(i);
        // Most rows end here, after loads that do not wait for each other.
        Index any = p;
        list.for_each(i, [&](Index j) {
          const Index q = nearest(j);
          any = q > any ? q : any;
        });
        if (any < 0) return;
        list.shorten(i, [&](Index j) {
          // Both tests see their own end first, so that i and j come to the same answer.
          const Index q = nearest(j);
          return !(p >= 0 && sheet_between(x(i), x(j), xs(p), normal(p), limit, edges, p)) &&
                 !(q >= 0 && sheet_between(x(j), x(i), xs(q), normal(q), limit, edges, q));
        });
      });
}

/// Around the owned particles of all ranks, as the ledger finds it.
PointBounds bounds_of_all(const Fluid& fluid) {
  const BoundsOverRanks own(find_bounds(fluid.particles.position, fluid.particles.count));
  return over_ranks(fluid.exchange.ranks(), own).bounds();
}

/// m: of a triangle's edges; two nodes of a sample are no farther apart.
Real longest_edge(const Cloth& cloth) {
  const Entries<const Real3> x = cloth.nodes.position;
  const Entries<const Index> triangle = cloth.mesh.triangle;
  return Real(maximum(
      "drench::exchange::longest_edge", 3 * cloth.mesh.triangles, KOKKOS_LAMBDA(const Index k) {
        const Index t = k / 3, a = triangle(k), b = triangle(3 * t + (k + 1) % 3);
        return double(norm(x(a) - x(b)));
      }));
}

/// The particles of this rank in the order of their cells, and behind them the ghosts; the cells hold both. Cells begin
/// where they would without ranks, so that rows are in the same order.
void sort_with_ghosts(const Constants& constants, Fluid& fluid, const Cloth& cloth, const PointBounds* bounds) {
  ParticleSet& particles = fluid.particles;
  const PointBounds all = bounds ? *bounds : bounds_of_all(fluid);
  // A node's row takes particles near any sample of its triangles, in the order in which one rank alone has them.
  const bool sheets = cloth.samples.count > 0;
  fluid.exchange.find_ghosts(particles, sheets ? longest_edge(cloth) : Real(0));
  fluid.cells.build(particles.position, particles.local(), constants.support, particles.id, &all,
                    sheets ? particles.total : 0);
  fluid.exchange.sort_owned(particles, fluid.cells.view().item);
}

}  // namespace

void neighbors(const Constants& constants, Fluid& fluid, NeighborLists& lists, Bodies& bodies, Cloth& cloth,
               const PointBounds* bounds) {
  const Real h = constants.support;
  ParticleSet& particles = fluid.particles;
  const bool alone = fluid.exchange.alone();
  fluid.exchange.migrate(particles);
  if (alone) {
    fluid.cells.build(particles.position, particles.count, h, particles.id, bounds);
    particles.reorder(fluid.cells.view().item);
  } else {
    sort_with_ghosts(constants, fluid, cloth, bounds);
  }
  const auto near_liquid = [&](NeighborList& list, const CellTableView& table) {
    return ListRequest{&list, &particles.position, particles.count, table};
  };
  std::vector<ListRequest> wanted{near_liquid(lists.fluid_fluid, fluid.cells.view())};
  wanted.back().same_set = true;
  wanted.back().compact = compact_pairs;
  wanted.back().in_order = alone;  // ghosts lie behind
  if (bodies.boundary.count > 0) {
    refresh_boundary_cells(constants, bodies);
    wanted.push_back(near_liquid(lists.fluid_boundary, bodies.cells.view()));
    list_body_neighbors(constants, fluid, bodies, lists);
  }
  const Samples& samples = cloth.samples;
  if (samples.count > 0) {
    // Stage porous_neighbors has left these where the samples still are.
    place_samples(cloth);
    refresh_sample_cells(constants, cloth);
    wanted.push_back(near_liquid(lists.fluid_sample, cloth.sample_cells.view()));
    wanted.back().rows = particles.local();
    wanted.push_back({&lists.sample_fluid, &samples.position, samples.count, fluid.cells.view()});
    if (!lists.sample_sample.is_of(cloth.moved))
      wanted.push_back({&lists.sample_sample, &samples.position, samples.count, cloth.sample_cells.view(), true});
    lists.sample_sample.set_made_from(cloth.moved);
  }
  build_neighbor_lists(wanted, h);
  if (samples.count > 0) find_filled_rows(lists.fluid_sample, particles.count, lists.near_sheet);
  if (samples.count > 0) fluid.exchange.keep_own_rows(samples.position, lists.sample_fluid);
  if (!has_sheet_contact(constants, cloth)) return;
  find_nearest_samples(lists, cloth, fluid);
  cull_pairs_across_cloth(constants, fluid, cloth, lists);
}

MemoryEstimate neighbor_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (!s.size.liquid) return sum;
  const SetupSize& size = s.size;
  sum.particles = nearest_sample_bytes(s);
  sum.cells = cell_table_bytes(size.fluid, size.fluid_cells, s);
  if (size.fluid > 0) sum.lists += liquid_list_bytes(size.fluid, s.entries.fluid_fluid, s);
  if (size.fluid > 0 && size.boundary > 0) sum.lists += list_bytes(size.fluid, s.entries.fluid_boundary, s);
  if (!(size.samples > 0)) return sum;
  sum.lists += list_bytes(size.samples, s.entries.sample_sample, s);
  sum.lists += list_bytes(size.samples, s.entries.sample_fluid, s);
  if (size.fluid > 0) sum.lists += list_bytes(size.fluid, s.entries.fluid_sample, s) + filled_rows_bytes(size.fluid, s);
  return sum;
}

}  // namespace drench::kokkos_backend
