// Stage porous_neighbors (src/stages/porous_neighbors.hpp). The liquid needs no cells here: stages absorption and
// emission go through its particles, and ask for the samples near each.

#include "core/filled_rows.hpp"
#include "core/neighbor_search.hpp"
#include "porous/diffusion.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {

void porous_neighbors(const Constants& constants, const Fluid& fluid, NeighborLists& lists, Bodies& bodies,
                      Cloth& cloth, DiffusionWork& diffusion) {
  const Model& m = constants.model;
  const Samples& samples = cloth.samples;
  std::vector<ListRequest> wanted;
  if (m.meets_porous() || m.has_contact_wicking()) place_samples(cloth);
  // Emission and contact wicking ask for samples near samples.
  if (m.has_fluid() || m.has_contact_wicking()) {
    refresh_sample_cells(constants, cloth);
    if (!lists.sample_sample.is_of(cloth.moved))
      wanted.push_back({&lists.sample_sample, &samples.position, samples.count, cloth.sample_cells.view(), true});
    lists.sample_sample.set_made_from(cloth.moved);
  }
  if (m.meets_porous())
    wanted.push_back(
        {&lists.fluid_sample, &fluid.particles.position, fluid.particles.count, cloth.sample_cells.view()});
  const Version both = cloth.moved + bodies.moved;
  if (m.porous_meets_solids() && bodies.boundary.count > 0 && !lists.sample_boundary.is_of(both)) {
    refresh_boundary_cells(constants, bodies);
    wanted.push_back({&lists.sample_boundary, &samples.position, samples.count, bodies.cells.view()});
    lists.sample_boundary.set_made_from(both);
  }
  // Of the nodes' positions alone: the host has its result after the same wait as the lists'.
  if (m.has_diffusion()) launch_diffusion_rate(constants, cloth, diffusion);
  if (build_neighbor_lists(wanted, constants.support)) diffusion.rate.waited = true;
  if (m.meets_porous()) find_filled_rows(lists.fluid_sample, fluid.particles.count, lists.near_sheet);
}

/// Beside the lists that stage neighbors has made.
MemoryEstimate porous_neighbor_bytes(const Sizing& s) {
  const SetupSize& size = s.size;
  MemoryEstimate sum;
  if (!(size.samples > 0)) return sum;
  if (!size.liquid && size.contact_wicking) sum.lists += list_bytes(size.samples, s.entries.sample_sample, s);
  const bool exchange = size.absorption || size.emission;
  if (size.liquid && ((exchange && size.direction) || (size.evaporation && size.porous)) && size.boundary > 0)
    sum.lists += list_bytes(size.samples, s.entries.sample_boundary, s);
  return sum;
}

}  // namespace drench::kokkos_backend
