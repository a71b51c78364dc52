// Stage drying (src/stages/drying.hpp). The liquid looks for samples, as in permeation; sums are integers.

#include "core/drawn.hpp"
#include "core/filled_rows.hpp"
#include "core/fixed_point.hpp"
#include "core/gather.hpp"
#include "porous/drying_law.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// Σ V W of the liquid on both sides of each sample.
void sum_liquid(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
                DryingWork& work) {
  const Entries<std::int64_t> sides = work.sides;
  parallel(
      "drench::drying::clear", 2 * cloth.samples.count, KOKKOS_LAMBDA(const Index k) { sides(k) = 0; });
  const Neighbors list(lists.fluid_sample);
  const Entries<const Real3> x = fluid.particles.position, at = cloth.samples.position, normal = cloth.samples.normal;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Kernel kernel = constants.kernel;
  const double quantum_volume = constants.quantum / constants.rest_density;  // m³
  if (fluid.particles.total > 0)
    parallel_filled_rows(
        "drench::drying::sides", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
          const NeighborRow near = list.row(i);
          if (near.count == 0) return;
          const double volume = quantum_volume * double(mass(i));
          const Real3 here = x(i);
          for (Index k = lane; k < near.count; k += row_lanes) {
            const Index p = near(k);
            const Real3 away = here - at(p);
            const double share = volume * double(kernel.value(norm(away)));
            Kokkos::atomic_add(&sides(2 * p + (dot(away, normal(p)) >= 0 ? 1 : 0)), fixed_point(share_units * share));
          }
        });
  fluid.exchange.add_up(work.sides, 2 * cloth.samples.count);
}

/// How many sides of each sample the air reaches: those that neither liquid nor solids cover.
void open_sides(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, const Cloth& cloth,
                DryingWork& work) {
  const Entries<const std::int64_t> sides = std::as_const(work).sides;
  const Entries<Real> open = work.open;
  const Entries<const Real3> at = cloth.samples.position, normal = cloth.samples.normal,
                             solid = bodies.boundary.position;
  const Entries<const Real> volume = bodies.boundary.volume;
  const Neighbors list(lists.sample_boundary);
  const bool solids = bodies.boundary.count > 0;
  const Kernel kernel = constants.kernel;
  parallel(
      "drench::drying::open", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        double filled[2] = {double(sides(2 * p)) / share_units, double(sides(2 * p + 1)) / share_units};
        const Real3 here = at(p), n = normal(p);
        const Neighbors::Row near = solids ? list.row(p) : Neighbors::Row{};
        near.for_each([&](Index b) {
          const Real3 away = solid(b) - here;
          filled[dot(away, n) >= 0 ? 1 : 0] += double(volume(b) * kernel.value(norm(away)));
        });
        open(p) = Real(laws::open_part(filled[0]) + laws::open_part(filled[1]));
      });
}

/// What a node loses; all that leaves the cloth, in quanta.
struct Drying {
  Entries<Quanta> liquid, buffered;
  Entries<const double> capacity, weight;
  Entries<const Index> start, item;
  Entries<const Real> area, open;
  Materials of_sample, of_node;
  double flux, cooling, quantum, dt;  // j of cloth that is wet all over, kg/(m² s); β, 1; q, kg; s
  std::int64_t step;
  bool covered;  // may anything cover a side?

  Drying(const Constants& constants, Cloth& cloth, const DryingWork& work, const StepInfo& info)
      : liquid(cloth.nodes.liquid),
        buffered(cloth.nodes.buffered),
        capacity(std::as_const(cloth).nodes.capacity),
        weight(std::as_const(cloth).samples.weight_exact),
        start(std::as_const(cloth).nodes.sample_start),
        item(std::as_const(cloth).nodes.sample_item),
        area(std::as_const(cloth).samples.area),
        open(work.open),
        of_sample(sample_materials(cloth)),
        of_node(node_materials(cloth)),
        flux(constants.model.evaporation_flux / (1 + constants.model.cooling)),
        cooling(constants.model.cooling),
        quantum(constants.quantum),
        dt(info.dt),
        step(info.step),
        covered(constants.model.has_fluid()) {}

  /// m²
  KOKKOS_INLINE_FUNCTION double open_area(Index n) const {
    double sum = 0;
    for (Index k = start(n); k < start(n + 1); ++k) {
      const Index p = item(k) / 4;
      if (!of_sample(p).porous) continue;
      const double sides = covered ? double(open(p)) : 2;
      sum += weight(3 * p + item(k) % 4) * double(area(p)) * sides;
    }
    return sum;
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index n, Quanta& sum) const {
    const Quanta held = liquid(n);
    if (held <= 0) return;
    const double rate = flux * open_area(n) / quantum;  // quanta/s
    if (!(rate > 0)) return;
    const double critical = double(of_node(n).critical_saturation) * capacity(n) / quantum;
    const double due = laws::dried(double(held), critical, rate, cooling, dt) + drawn(n, step);
    const Quanta gone = due < double(held) ? static_cast<Quanta>(Kokkos::floor(due)) : held;
    liquid(n) = held - gone;
    if (buffered(n) > held - gone) buffered(n) = held - gone;
    sum += gone;
  }
};

}  // namespace

void drying(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
            Cloth& cloth, DryingWork& work, Accounts& accounts, const StepInfo& info) {
  cloth.soaked.advance();
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  if (samples == 0) return;
  if (constants.model.has_fluid()) {
    make_room(work.sides, "drench::drying::sides", 2 * samples);
    make_room(work.open, "drench::drying::open", samples);
    sum_liquid(constants, fluid, lists, cloth, work);
    open_sides(constants, lists, bodies, cloth, work);
  }
  Quanta gone = 0;  // every rank has all nodes
  Kokkos::parallel_reduce("drench::drying::nodes", range(cloth.nodes.count), Drying(constants, cloth, work, info),
                          gone);
  accounts.evaporated += gone;
}

MemoryEstimate drying_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.evaporation && s.size.porous && s.size.liquid)
    sum.cloth = s.size.samples * (2 * sizeof(std::int64_t) + s.real);
  return sum;
}

}  // namespace drench::kokkos_backend
