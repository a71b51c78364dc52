// Stage evaporation (src/stages/evaporation.hpp).

#include "core/drawn.hpp"
#include "core/liquid_pairs.hpp"
#include "coupling/wall.hpp"
#include "fluid/evaporation_law.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// ∇c of the liquid and of all that it touches.
struct ColourOf {
  Kernel kernel;
  Entries<const Real4> position, sheet, offset;  // x_i, m, and V_i, m³; x_b and V_b; ½ d n_b, m
  Entries<const Real3> solid;
  Entries<const Real> solid_volume;
  LiquidNeighbors liquid;
  Neighbors near_solids, near_sheets;
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

  KOKKOS_INLINE_FUNCTION laws::Colour operator()(Index i) const {
    const Real4 own = position(i);
    laws::Colour sum;
    sum.number = kernel.value(0);
    sum.liquid = own.w * sum.number;
    liquid.for_each(i, [&](Index j) {
      const Real4 other = position(j);
      sum.add_liquid(kernel, other.w, own.xyz() - other.xyz());
    });
    if (solids) add_solids(i, own.xyz(), sum);
    if (sheets) add_sheets(i, own.xyz(), sum);
    return sum;
  }

 private:
  KOKKOS_INLINE_FUNCTION void add_solids(Index i, const Real3& xi, laws::Colour& sum) const {
    near_solids.for_each(i, [&](Index j) { sum.add_solid(kernel, solid_volume(j), xi - solid(j)); });
  }
  KOKKOS_INLINE_FUNCTION void add_sheets(Index i, const Real3& xi, laws::Colour& sum) const {
    near_sheets.for_each(i, [&](Index j) {
      const Real4 at = sheet(j);
      sum.add_solid(kernel, at.w, from_behind(xi - at.xyz(), offset(j).xyz()));
    });
  }
};

/// In `work`; the number is −1 of a particle that is alone: it is a drop by itself.
void find_colours(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                  const Cloth& cloth, EvaporationWork& work) {
  make_room(work.colour, "drench::evaporation::colour", fluid.particles.capacity());
  make_room(work.number, "drench::evaporation::number", fluid.particles.capacity());
  make_room(work.solid, "drench::evaporation::solid", fluid.particles.capacity());
  make_room(work.moment, "drench::evaporation::moment", fluid.particles.capacity());
  const ColourOf colour_of(constants, fluid, lists, bodies, cloth);
  const Entries<Real4> colour = work.colour;
  const Entries<Real> number = work.number, solid = work.solid, moment = work.moment;
  parallel(
      "drench::evaporation::colour", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const laws::Colour sum = colour_of(i);
        colour(i) = sum.of_room();
        number(i) = sum.near > 0 ? sum.number : Real(-1);
        solid(i) = sum.solid;
        moment(i) = sum.moment;
      });
  fluid.exchange.halo(work.colour);
  fluid.exchange.halo(work.moment);
}

laws::Surface surface_of(const Constants& constants) {
  return {constants.kernel.kind, constants.model.spacing, constants.model.support};
}

/// The surface's normals and what lies within it, in `work`.
void find_normals(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, EvaporationWork& work) {
  make_room(work.normal, "drench::evaporation::normal", fluid.particles.capacity());
  make_room(work.inside, "drench::evaporation::inside", fluid.particles.capacity());
  const laws::Surface surface = surface_of(constants);
  const Real inverse_h2 = constants.kernel.inverse_h * constants.kernel.inverse_h;
  const LiquidNeighbors liquid(lists.fluid_fluid);
  const Entries<const Real4> position = fluid.position_volume, colour = std::as_const(work).colour;
  const Entries<const Real> number = std::as_const(work).number, solid = std::as_const(work).solid;
  const Entries<Real4> normal = work.normal;
  const Entries<Real> inside = work.inside;
  parallel(
      "drench::evaporation::normal", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real4 at = position(i), own = colour(i);
        Real3 sum = at.w * own.xyz();
        liquid.for_each(i, [&](Index j) {
          const Real4 other = position(j);
          const Real3 r = at.xyz() - other.xyz();
          sum += other.w * (1 - dot(r, r) * inverse_h2) * colour(j).xyz();
        });
        const Real4 found = surface.normal(surface.smooth * sum, own.w);
        normal(i) = found;
        inside(i) = (1 - found.w) * (1 - surface.thin(surface.filled(number(i), solid(i)))) * at.w;
      });
  fluid.exchange.halo(work.normal);
  fluid.exchange.halo(work.inside);
}

/// f F of a particle, and how much of the inside is near.
struct FlatAreas {
  Kernel kernel;
  laws::Surface surface;
  Entries<const Real4> position, colour, normal;
  Entries<const Real> moment, inside;
  Entries<Real> flat, near_inside, moment_of_inside;
  LiquidNeighbors liquid;

  FlatAreas(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, EvaporationWork& work)
      : kernel(constants.kernel),
        surface(surface_of(constants)),
        position(fluid.position_volume),
        colour(std::as_const(work).colour),
        normal(std::as_const(work).normal),
        moment(std::as_const(work).moment),
        inside(std::as_const(work).inside),
        flat(work.flat),
        near_inside(work.near_inside),
        moment_of_inside(work.moment_of_inside),
        liquid(lists.fluid_fluid) {}

  KOKKOS_INLINE_FUNCTION void operator()(const Index i) const {
    const Real4 own = normal(i);
    Real curvature = 0, near = 0, sum = 0;
    if (own.w > 0) look_around(i, own.xyz(), curvature, near, sum);
    flat(i) = own.w * surface.flat_area(position(i).w, -dot(colour(i).xyz(), own.xyz()), curvature);
    near_inside(i) = near;
    moment_of_inside(i) = sum;
  }

 private:
  /// H, 1/m, by least squares of n_j − n_i = H r_t along the surface; C and B.
  KOKKOS_INLINE_FUNCTION void look_around(Index i, const Real3& n, Real& curvature, Real& near, Real& sum) const {
    const Real3 x = position(i).xyz();
    Real turned = 0, square = 0;
    near = kernel.value(0) * inside(i);
    sum = near * moment(i);
    liquid.for_each(i, [&](Index j) {
      const Real4 other = position(j), of_other = normal(j);
      const Real3 r = other.xyz() - x, along = r - dot(n, r) * n;
      const Real w = kernel.value(norm(r)), within = w * inside(j);
      near += within;
      sum += within * moment(j);
      if (!(of_other.w > 0)) return;
      turned += other.w * w * dot(of_other.xyz() - n, along);
      square += other.w * w * dot(along, along);
    });
    if (square > 0) curvature = turned / square;
  }
};

void find_flat_areas(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                     EvaporationWork& work) {
  make_room(work.flat, "drench::evaporation::flat", fluid.particles.capacity());
  make_room(work.near_inside, "drench::evaporation::near_inside", fluid.particles.capacity());
  make_room(work.moment_of_inside, "drench::evaporation::moment_of_inside", fluid.particles.capacity());
  parallel("drench::evaporation::flat", fluid.particles.count, FlatAreas(constants, fluid, lists, work));
  fluid.exchange.halo(work.flat);
  fluid.exchange.halo(work.near_inside);
  fluid.exchange.halo(work.moment_of_inside);
}

/// What a particle whose gradient points inwards takes from those around it, in `work`.
void find_taken(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, EvaporationWork& work) {
  make_room(work.taken, "drench::evaporation::taken", fluid.particles.capacity());
  const laws::Surface surface = surface_of(constants);
  const Kernel kernel = constants.kernel;
  const LiquidNeighbors liquid(lists.fluid_fluid);
  const Entries<const Real4> position = fluid.position_volume;
  const Entries<const Real> flat = std::as_const(work).flat, number = std::as_const(work).number,
                            solid = std::as_const(work).solid;
  const Entries<Real> taken = work.taken;
  parallel(
      "drench::evaporation::taken", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        taken(i) = 0;
        if (!(flat(i) < 0)) return;
        const Real3 x = position(i).xyz();
        Real given = 0;
        liquid.for_each(i, [&](Index j) {
          const Real other = flat(j);
          if (other > 0) given += kernel.value(norm(position(j).xyz() - x)) * other;
        });
        if (given > 0) taken(i) = -(1 - surface.thin(surface.filled(number(i), solid(i)))) * flat(i) / given;
      });
  fluid.exchange.halo(work.taken);
}

/// What a particle loses; all of it, in quanta.
struct Evaporation {
  Kernel kernel;
  laws::Surface surface;
  Entries<const Real4> position, colour, normal;
  Entries<const Real> number, solid, flat, taken, near_inside, moment_of_inside;
  Entries<const std::int64_t> id;
  Entries<Quanta> mass;
  LiquidNeighbors liquid;
  double rate;  // j Δt/q, quanta/m²
  Quanta least;
  std::int64_t step;

  Evaporation(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const EvaporationWork& work,
              const StepInfo& info)
      : kernel(constants.kernel),
        surface(surface_of(constants)),
        position(std::as_const(fluid).position_volume),
        colour(work.colour),
        normal(work.normal),
        number(work.number),
        solid(work.solid),
        flat(work.flat),
        taken(work.taken),
        near_inside(work.near_inside),
        moment_of_inside(work.moment_of_inside),
        id(std::as_const(fluid).particles.id),
        mass(fluid.particles.mass),
        liquid(lists.fluid_fluid),
        rate(constants.model.evaporation_flux * info.dt / constants.quantum),
        least(constants.model.min_quanta),
        step(info.step) {}

  /// A_i, m².
  KOKKOS_INLINE_FUNCTION Real area(Index i) const {
    const Real4 at = position(i), own = normal(i);
    const Real drop = laws::round_drop_area(at.w);
    if (number(i) < 0) return drop;
    const Real sides = surface.both_sides(number(i)), open = surface.open(solid(i));
    const Real small = drop < sides * open ? drop : sides * open;
    const Real filled = surface.filled(number(i), solid(i)), thin = surface.thin(filled);
    if (!(own.w > 0)) return thin * small;
    const Real inwards = -dot(colour(i).xyz(), own.xyz()), steep = inwards > 0 ? inwards : Real(0);
    const Real rim = thin * surface.unexplained(filled, steep), loose = surface.loose(filled);
    const Real few = own.w * (rim > loose ? rim : loose) * small, most = own.w * 2 * sides * open * open;
    const Real outward = outward_area(i, at.xyz()), bound = outward < most ? outward : most;
    return (bound > few ? bound : few) + (1 - own.w) * thin * small;
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index i, Quanta& sum) const {
    const Quanta held = mass(i);
    if (held <= 0) return;
    const double due = rate * double(area(i));
    if (!(due > 0)) return;
    const double u = drawn(id(i), step);
    Quanta gone = due < double(held) ? static_cast<Quanta>(Kokkos::floor(due + u)) : held;
    if (held - gone < least) gone = u * double(held) < due ? held : 0;
    mass(i) = held - gone;
    sum += gone;
  }

 private:
  /// f A^f, m²: without what is taken, and of a kernel whose moment is that of the inside.
  KOKKOS_INLINE_FUNCTION Real outward_area(Index i, const Real3& x) const {
    if (!(flat(i) > 0)) return 0;
    const Real own = kernel.value(0) * position(i).w;
    Real away = 0, near = own * near_inside(i), moment = own * moment_of_inside(i);
    liquid.for_each(i, [&](Index j) {
      const Real4 other = position(j);
      const Real w = kernel.value(norm(other.xyz() - x));
      away += w * taken(j);
      near += w * other.w * near_inside(j);
      moment += w * other.w * moment_of_inside(j);
    });
    const Real left = away < 1 ? (1 - away) * flat(i) : Real(0);
    return near > 0 ? left * near / moment : left;
  }
};

}  // namespace

void evaporation(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                 const Cloth& cloth, EvaporationWork& work, Accounts& accounts, const StepInfo& info) {
  if (fluid.particles.total == 0) return;
  find_colours(constants, fluid, lists, bodies, cloth, work);
  find_normals(constants, fluid, lists, work);
  find_flat_areas(constants, fluid, lists, work);
  find_taken(constants, fluid, lists, work);
  Quanta gone = 0;
  Kokkos::parallel_reduce("drench::evaporation::loss", range(fluid.particles.count),
                          Evaporation(constants, fluid, lists, work, info), gone);
  OverRanks(constants.ranks).sum(gone).reduce();
  accounts.evaporated += gone;
}

MemoryEstimate evaporation_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.evaporation && s.size.liquid)
    sum.particles = particle_room(s) * 16 * s.real;  // colour and normal of four, eight of one
  return sum;
}

}  // namespace drench::kokkos_backend
