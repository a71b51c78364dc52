// Stage evaporation (src/stages/evaporation.hpp).

#include "core/drawn.hpp"
#include "coupling/wall.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Real flat_gradient = Real(0.1);  // 1/d: a mean ∇c/c below it is that of a particle within the liquid

/// ∇c, 1/m, and c, 1.
struct Colour {
  Real3 gradient;
  Real value = 0;
  Index near = 0;  // that it is summed over

  KOKKOS_INLINE_FUNCTION void add(const Kernel& kernel, Real volume, const Real3& r) {
    const Real length = norm(r);
    gradient += volume * kernel.grad_factor(length) * r;
    value += volume * kernel.value(length);
    ++near;
  }
};

/// ∇c of the liquid and of all that it touches.
struct ColourOf {
  Kernel kernel;
  Entries<const Real4> position, sheet, offset;  // x_i, m, and V_i, m³; x_b and V_b; ½ d n_b, m
  Entries<const Real3> solid;
  Entries<const Real> solid_volume;
  Neighbors liquid, near_solids, near_sheets;
  bool solids, sheets;

  ColourOf(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
           const Cloth& cloth)
      : kernel(constants.kernel),
        position(fluid.position_volume),
        sheet(cloth.samples.position_volume),
        offset(cloth.samples.normal_offset),
        solid(bodies.boundary.position),
        solid_volume(bodies.boundary.volume),
        liquid(lists.fluid_fluid),
        near_solids(lists.fluid_boundary),
        near_sheets(lists.fluid_sample),
        solids(bodies.boundary.count > 0),
        sheets(cloth.samples.count > 0) {}

  KOKKOS_INLINE_FUNCTION Colour operator()(Index i) const {
    const Real4 own = position(i);
    Colour sum;
    sum.value = own.w * kernel.value(0);
    const NeighborRow near = liquid.row(i);
    for (Index k = 0; k < near.count; ++k) sum.add(kernel, position(near(k)).w, own.xyz() - position(near(k)).xyz());
    if (solids) add_solids(i, own.xyz(), sum);
    if (sheets) add_sheets(i, own.xyz(), sum);
    return sum;
  }

 private:
  KOKKOS_INLINE_FUNCTION void add_solids(Index i, const Real3& xi, Colour& sum) const {
    const NeighborRow near = near_solids.row(i);
    for (Index k = 0; k < near.count; ++k) sum.add(kernel, solid_volume(near(k)), xi - solid(near(k)));
  }
  KOKKOS_INLINE_FUNCTION void add_sheets(Index i, const Real3& xi, Colour& sum) const {
    const NeighborRow near = near_sheets.row(i);
    for (Index k = 0; k < near.count; ++k) {
      const Real4 at = sheet(near(k));
      sum.add(kernel, at.w, from_behind(xi - at.xyz(), offset(near(k)).xyz()));
    }
  }
};

/// In `work.colour`; c = −1 of a particle that is alone: it is a drop by itself.
void find_colours(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                  const Cloth& cloth, EvaporationWork& work) {
  make_room(work.colour, "drench::evaporation::colour", fluid.particles.capacity());
  const ColourOf colour_of(constants, fluid, lists, bodies, cloth);
  const Entries<Real4> colour = work.colour;
  parallel(
      "drench::evaporation::colour", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Colour sum = colour_of(i);
        colour(i) = {sum.gradient, sum.near > 0 ? sum.value : Real(-1)};
      });
  fluid.exchange.halo(work.colour);
}

/// What a particle loses; all of it, in quanta.
struct Evaporation {
  Kernel kernel;
  Entries<const Real4> position, colour;
  Entries<const std::int64_t> id;
  Entries<Quanta> mass;
  Neighbors liquid;
  double rate;  // j Δt/q, quanta/m²
  Quanta least;
  Real flat;  // 1/m
  std::int64_t step;

  Evaporation(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const EvaporationWork& work,
              const StepInfo& info)
      : kernel(constants.kernel),
        position(std::as_const(fluid).position_volume),
        colour(std::as_const(work).colour),
        id(std::as_const(fluid).particles.id),
        mass(fluid.particles.mass),
        liquid(lists.fluid_fluid),
        rate(constants.model.evaporation_flux * info.dt / constants.quantum),
        least(constants.model.min_quanta),
        flat(flat_gradient / constants.spacing),
        step(info.step) {}

  /// A_i, m².
  KOKKOS_INLINE_FUNCTION double area(Index i) const {
    const Real4 at = position(i), own = colour(i);
    if (own.w < 0) return double(round_drop_area(at.w));
    Real3 smooth = at.w * kernel.value(0) * own.xyz();
    const NeighborRow near = liquid.row(i);
    for (Index k = 0; k < near.count; ++k) {
      const Real4 other = position(near(k));
      smooth += other.w * kernel.value(norm(at.xyz() - other.xyz())) * colour(near(k)).xyz();
    }
    const Real length = norm(smooth), inwards = dot(own.xyz(), smooth);
    return length < flat * own.w * own.w || !(inwards > 0) ? 0 : double(2 * at.w * inwards / length);
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index i, Quanta& sum) const {
    const Quanta held = mass(i);
    const double due = rate * area(i);
    if (held <= 0 || !(due > 0)) return;
    const double u = drawn(id(i), step);
    Quanta gone = due < double(held) ? static_cast<Quanta>(Kokkos::floor(due + u)) : held;
    if (held - gone < least) gone = u * double(held) < due ? held : 0;
    mass(i) = held - gone;
    sum += gone;
  }

 private:
  /// (36 π)^⅓ V^⅔ of a volume in m³.
  KOKKOS_INLINE_FUNCTION static Real round_drop_area(Real volume) {
    const Real edge = Kokkos::cbrt(volume);
    return Real(4.835975862049408) * edge * edge;
  }
};

}  // namespace

void evaporation(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                 const Cloth& cloth, EvaporationWork& work, Accounts& accounts, const StepInfo& info) {
  if (fluid.particles.total == 0) return;
  find_colours(constants, fluid, lists, bodies, cloth, work);
  Quanta gone = 0;
  Kokkos::parallel_reduce("drench::evaporation::loss", range(fluid.particles.count),
                          Evaporation(constants, fluid, lists, work, info), gone);
  OverRanks(constants.ranks).sum(gone).reduce();
  accounts.evaporated += gone;
}

MemoryEstimate evaporation_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.evaporation && s.size.liquid) sum.particles = particle_room(s) * 4 * s.real;  // colour
  return sum;
}

}  // namespace drench::kokkos_backend
