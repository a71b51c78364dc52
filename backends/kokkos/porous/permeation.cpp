// Stage permeation (src/stages/permeation.hpp). The liquid looks for samples, as in absorption; sums are integers.

#include "core/filled_rows.hpp"
#include "core/fixed_point.hpp"
#include "core/sizing.hpp"
#include "coupling/wall.hpp"
#include "porous/permeation_law.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double share_units = 1099511627776.0;   // 2^40, of V W
constexpr double load_units = 1073741824.0;       // 2^30, of loads in m²/s²
constexpr double most_load = 1e8;                 // m²/s² of a pair: sums of a thousand fit

/// Σ V W on both sides of each sample, and its load.
void sum_sides(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth, PermeationWork& work) {
  const Entries<std::int64_t> sides = work.sides;
  parallel("drench::permeation::clear", 3 * cloth.samples.count, KOKKOS_LAMBDA(const Index k) { sides(k) = 0; });
  const Neighbors list(lists.fluid_sample);
  const Entries<const Real3> x = fluid.particles.position, at = cloth.samples.position, normal = cloth.samples.normal;
  const Entries<const Real> density = fluid.particles.kappa_density, divergence = fluid.particles.kappa_divergence,
                            ratio = fluid.particles.density_ratio, sample_volume = cloth.samples.volume, area = cloth.samples.area;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Materials materials = sample_materials(cloth);
  const Kernel kernel = constants.kernel;
  const Real behind = constants.spacing / 2;
  const double quantum_volume = constants.quantum / constants.rest_density;  // m³
  parallel_filled_rows(
      "drench::permeation::sides", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const NeighborRow near = list.row(i);
        if (near.count == 0) return;
        const double volume = quantum_volume * double(mass(i));
        const double weight = double(mirrored) * double(image_density(ratio(i))) * volume * double(density(i) + divergence(i));
        const Real3 here = x(i);
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Index p = near(k);
          if (!(materials(p).conductance > 0)) continue;
          const Real3 away = here - at(p), n = normal(p);
          const bool along = dot(away, n) >= 0;
          Kokkos::atomic_add(&sides(3 * p + (along ? 1 : 0)), fixed_point(share_units * volume * double(kernel.value(norm(away)))));
          const double load = weight * double(sample_volume(p)) / double(area(p)) *
                              double(dot(kernel.gradient(away + (along ? behind : -behind) * n), n));
          Kokkos::atomic_add(&sides(3 * p + 2), fixed_point(load_units * Kokkos::fmax(-most_load, Kokkos::fmin(most_load, load))));
        }
      });
  fluid.exchange.add_up(work.sides, 3 * cloth.samples.count);
}

/// u_p, its direction and the supply.
void drive(const Constants& constants, Cloth& cloth, PermeationWork& work) {
  const Entries<const std::int64_t> sides = std::as_const(work).sides;
  const Entries<Real> flux = cloth.samples.flux, supply = work.supply;
  const Entries<Real3> direction = cloth.samples.flow_direction;
  const Entries<const Real3> normal = cloth.samples.normal;
  const Materials materials = sample_materials(cloth);
  const Real3 gravity = constants.gravity;
  parallel(
      "drench::permeation::drive", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        flux(p) = 0;
        const Material& m = materials(p);
        if (!(m.conductance > 0)) return;
        const Real3 n = normal(p);
        const double filled[2] = {double(sides(3 * p)) / share_units, double(sides(3 * p + 1)) / share_units};
        const double air = laws::air_share(filled[0]) + laws::air_share(filled[1]);
        const double drop = double(sides(3 * p + 2)) / load_units + 0.5 * air * double(m.thickness) * double(dot(gravity, n));
        const double upstream = filled[drop > 0 ? 0 : 1];
        if (Kokkos::fabs(drop) > double(m.entry_potential) && upstream > 0) {
          flux(p) = Real(double(m.conductance) * drop);
          direction(p) = Real(drop > 0 ? 1 / 1.001 : -1 / 1.001) * n;
          supply(p) = Real(upstream > laws::full_side ? upstream : laws::full_side);
        } else if (filled[0] > laws::covered_side && filled[1] > laws::covered_side) {
          direction(p) = Real3{};
        }
      });
}

}  // namespace

void permeation(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Cloth& cloth, PermeationWork& work) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  if (samples == 0) return;
  make_room(work.sides, "drench::permeation::sides", 3 * samples);
  make_room(work.supply, "drench::permeation::supply", samples);
  place_samples(cloth);
  sum_sides(constants, fluid, lists, cloth, work);
  drive(constants, cloth, work);
}

MemoryEstimate permeation_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.permeation)  // sides, supply; pull of absorption
    sum.cloth = s.size.samples * (3 * sizeof(std::int64_t) + 5 * s.real);
  return sum;
}

}  // namespace drench::kokkos_backend
