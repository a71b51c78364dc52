// Stage permeation (src/stages/permeation.hpp). The liquid looks for samples, as in absorption; sums are integers.

#include "core/filled_rows.hpp"
#include "core/fixed_point.hpp"
#include "core/sizing.hpp"
#include "coupling/wall.hpp"
#include "porous/permeation_law.hpp"
#include "porous/stages.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr double potential_units = share_units;  // of loads and of V W φ in m²/s²

/// In these units; a thousand of the largest sum up within 64 bits.
KOKKOS_INLINE_FUNCTION std::int64_t fixed_potential(double value) {
  constexpr double most = 5e3;  // m²/s²: 50 bar
  return fixed_point(potential_units * larger(-most, smaller(most, value)));
}

/// Σ V W and Σ V W φ on both sides of each sample, and its load.
void sum_sides(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Cloth& cloth,
               PermeationWork& work) {
  const Entries<std::int64_t> sides = work.sides;
  parallel(
      "drench::permeation::clear", 5 * cloth.samples.count, KOKKOS_LAMBDA(const Index k) { sides(k) = 0; });
  const Neighbors list(lists.fluid_sample);
  const Entries<const Real3> x = fluid.particles.position, at = cloth.samples.position, normal = cloth.samples.normal;
  const Entries<const Real> density = fluid.particles.kappa_density, divergence = fluid.particles.kappa_divergence,
                            ratio = fluid.particles.density_ratio, sample_volume = cloth.samples.volume,
                            area = cloth.samples.area;
  const Entries<const Quanta> mass = fluid.particles.mass;
  const Materials materials = sample_materials(cloth);
  const Kernel kernel = constants.kernel;
  const Real3 gravity = constants.gravity;
  const Real behind = constants.spacing / 2;
  const double quantum_volume = constants.quantum / constants.rest_density;  // m³
  parallel_filled_rows(
      "drench::permeation::sides", lists.near_sheet, KOKKOS_LAMBDA(const Index i, const Index lane) {
        const NeighborRow near = list.row(i);
        if (near.count == 0) return;
        const double volume = quantum_volume * double(mass(i));
        const Real kappa = density(i) + divergence(i);
        const double weight = double(mirrored) * double(image_density(ratio(i))) * volume * double(kappa);
        const Real3 here = x(i);
        for (Index k = lane; k < near.count; k += row_lanes) {
          const Index p = near(k);
          if (!(materials(p).conductance > 0)) continue;
          const Real3 away = here - at(p), n = normal(p);
          const bool along = dot(away, n) >= 0;
          const Real carried = kappa - dot(gravity, away);
          const double share = volume * double(kernel.value(norm(away)));
          Kokkos::atomic_add(&sides(5 * p + (along ? 2 : 0)), fixed_point(share_units * share));
          if (carried > 0)
            Kokkos::atomic_add(&sides(5 * p + (along ? 3 : 1)), fixed_potential(share * double(carried)));
          const double load = weight * double(sample_volume(p)) / double(area(p)) *
                              double(dot(kernel.gradient(away + (along ? behind : -behind) * n), n));
          Kokkos::atomic_add(&sides(5 * p + 4), fixed_potential(load));
        }
      });
  fluid.exchange.add_up(work.sides, 5 * cloth.samples.count);
}

/// u_p, what of it passes, its direction and the supply.
void drive(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, Cloth& cloth,
           PermeationWork& work, double dt) {
  const Entries<const std::int64_t> sides = std::as_const(work).sides;
  const Entries<Real> flux = cloth.samples.flux, passing = cloth.samples.passing, supply = work.supply;
  const Entries<Real3> direction = cloth.samples.flow_direction;
  const Entries<const Real3> normal = cloth.samples.normal;
  const Materials materials = sample_materials(cloth);
  const Neighbors solid(lists.sample_boundary);
  const Entries<const Real3> at = cloth.samples.position, wall = bodies.boundary.position;
  const Entries<const Real> volume = bodies.boundary.volume;
  const bool extrapolates = constants.model.extrapolates_walls();
  const Kernel kernel = constants.kernel;
  const Real3 gravity = constants.gravity;
  const double unresolved = double(constants.spacing) * double(norm(gravity));
  parallel(
      "drench::permeation::drive", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        const Material& m = materials(p);
        if (!(m.conductance > 0)) return;
        const Real3 n = normal(p);
        laws::Surroundings liquid;
        for (int side = 0; side < 2; ++side) {
          liquid.filled[side] = double(sides(5 * p + 2 * side)) / share_units;
          liquid.potential[side] = double(sides(5 * p + 2 * side + 1)) / potential_units;
        }
        Real walls = 0;
        if (extrapolates) {
          solid.for_each(p, [&](Index j) { walls += volume(j) * kernel.value(norm(at(p) - wall(j))); });
        }
        liquid.at_walls = 1 - laws::air_share(double(walls));  // full from A_0 on
        liquid.load = double(sides(5 * p + 4)) / potential_units;
        const double now = laws::flux_of(m, liquid.drive(0.5 * double(m.thickness) * double(dot(gravity, n))));
        const double before = double(flux(p)), mean = before + dt / (dt + double(m.emission_ramp)) * (now - before);
        const double upstream = liquid.filled[mean > 0 ? 0 : 1];
        flux(p) = upstream > 0 ? Real(mean) : Real(0);
        const Real u = Real(laws::beyond(m, double(flux(p)), liquid.covered() * unresolved));
        passing(p) = u;
        if (laws::is_open(u, m)) {
          direction(p) = Real(u > 0 ? 1 / 1.001 : -1 / 1.001) * n;
          supply(p) = Real(upstream > laws::full_side ? upstream : laws::full_side);
        } else if (liquid.filled[0] > laws::covered_side && liquid.filled[1] > laws::covered_side) {
          direction(p) = Real3{};
        }
      });
}

}  // namespace

void permeation(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                Cloth& cloth, PermeationWork& work, const StepInfo& info) {
  const auto samples = static_cast<std::size_t>(cloth.samples.count);
  if (samples == 0) return;
  make_room(work.sides, "drench::permeation::sides", 5 * samples);
  make_room(work.supply, "drench::permeation::supply", samples);
  place_samples(cloth);
  sum_sides(constants, fluid, lists, cloth, work);
  drive(constants, lists, bodies, cloth, work, info.dt);
}

MemoryEstimate permeation_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.permeation)  // sides, supply; what passes; pull of absorption
    sum.cloth = s.size.samples * (5 * sizeof(std::int64_t) + 6 * s.real);
  return sum;
}

}  // namespace drench::kokkos_backend
