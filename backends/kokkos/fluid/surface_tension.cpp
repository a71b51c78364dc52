// Stage surface_tension (src/stages/surface_tension.hpp).

#include <limits>

#include "core/host_copy.hpp"
#include "core/liquid_pairs.hpp"
#include "coupling/wall.hpp"
#include "coupling/wall_push.hpp"
#include "fluid/stages.hpp"
#include "fluid/surface_tension_law.hpp"

namespace drench::kokkos_backend {
namespace {

/// A_b of works of adhesion, on first use; stays empty where none is above 0.
void allocate_strengths(Field<Real>& strength, const char* label, const std::vector<double>& adhesion,
                        const Constants& constants) {
  if (strength.extent(0) > 0) return;
  std::vector<double> values;
  bool any = false;
  for (const double work : adhesion) {
    values.push_back(wall_cohesion(constants.kernel.kind, work, constants.model.scene.fluid.surface_tension,
                                   constants.model.support));
    any = any || work > 0;
  }
  if (any) strength = to_device<Real>(label, values);
}

/// Work arrays, on first use.
void allocate(const Constants& constants, const Fluid& fluid, SurfaceTensionWork& work) {
  std::vector<double> bodies, cloths;
  for (const Body& b : constants.model.bodies) bodies.push_back(b.adhesion);
  constants.model.for_materials([&](const ClothMaterial& c) { cloths.push_back(c.adhesion); });
  allocate_strengths(work.body_adhesion, "drench::surface_tension::body_adhesion", bodies, constants);
  allocate_strengths(work.cloth_adhesion, "drench::surface_tension::cloth_adhesion", cloths, constants);
  if (constants.model.scene.fluid.surface_tension > 0)
    make_room(work.normal, "drench::surface_tension::normal", fluid.particles.capacity());
}

/// Samples of solids and cloths that the liquid sticks to.
struct StickyWalls {
  Kernel kernel;
  Entries<const Real3> solid;          // m
  Entries<const Real4> sheet, offset;  // m and m³; ½ d n, m
  Entries<const Real> solid_volume;    // m³
  Entries<const Index> body, cloth;
  Slice<const Real> of_body, of_cloth;  // A_b, Pa
  Neighbors near_solids, near_sheets;
  bool solids, sheets;

  StickyWalls(const Constants& constants, const NeighborLists& lists, const Bodies& bodies, const Cloth& cloths,
              const SurfaceTensionWork& work)
      : kernel(constants.kernel),
        solid(bodies.boundary.position),
        sheet(cloths.samples.position_volume),
        offset(cloths.samples.normal_offset),
        solid_volume(bodies.boundary.volume),
        body(bodies.boundary.body),
        cloth(material_numbers(cloths.samples)),
        of_body(work.body_adhesion),
        of_cloth(work.cloth_adhesion),
        near_solids(lists.fluid_boundary),
        near_sheets(lists.fluid_sample),
        solids(of_body.extent(0) > 0 && bodies.boundary.count > 0),
        sheets(of_cloth.extent(0) > 0 && cloths.samples.count > 0) {}

  /// Σ_b min(A_b, most) V_b ∇W_ib, Pa/m.
  KOKKOS_INLINE_FUNCTION Real3 pull(Index i, const Real3& xi, Real most) const {
    Real3 sum;
    if (solids) {
      near_solids.for_each(i, [&](Index b) {
        const Real3 r = xi - solid(b);
        sum += Kokkos::min(of_body(body(b)), most) * solid_volume(b) * kernel.grad_factor(norm(r)) * r;
      });
    }
    if (sheets) {
      near_sheets.for_each(i, [&](Index b) {
        const Real4 at = sheet(b);
        const Real3 r = from_behind(xi - at.xyz(), offset(b).xyz());
        sum += Kokkos::min(of_cloth(cloth(b)), most) * at.w * kernel.grad_factor(norm(r)) * r;
      });
    }
    return sum;
  }
};

/// n_i = h (Σ_j V_j ∇W_ij + Σ_b η_b V_b ∇W_ib), η_b = A_b/A, at most 2.
void surface_normals(const Constants& constants, const Fluid& fluid, const NeighborLists& lists,
                     const StickyWalls& walls, SurfaceTensionWork& work) {
  const Kernel kernel = constants.kernel;
  const Cohesion law(kernel, constants.model.scene.fluid.surface_tension, constants.model.support);
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> normal = work.normal;
  const Entries<const Real> volume = fluid.volume;
  const LiquidNeighbors list(lists.fluid_fluid);
  const Real inverse_pressure = 1 / law.pressure, most = 2 * law.pressure;
  parallel(
      "drench::surface_tension::normal", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i);
        Real3 sum = inverse_pressure * walls.pull(i, xi, most);
        list.for_each(i, [&](Index j) {
          const Real3 r = xi - x(j);
          sum += volume(j) * kernel.grad_factor(norm(r)) * r;
        });
        normal(i) = kernel.h * sum;
      });
  fluid.exchange.halo(work.normal);
}

/// How a particle takes up a change of its velocity: beside walls that extrapolate the pressure L_i times, as it does
/// that of the pressure, which holds against these forces.
struct Uptake {
  Entries<const Real3> diagonal, shear;
  Entries<Real3> velocity, push;
  bool gains, pushes, adds;

  /// `more`: beside what fluid.wall_gain.push has already.
  Uptake(const Constants& constants, const Bodies& bodies, Fluid& fluid, bool more)
      : diagonal(std::as_const(fluid).wall_gain.diagonal),
        shear(std::as_const(fluid).wall_gain.shear),
        velocity(fluid.particles.velocity),
        gains(constants.model.extrapolates_walls()),
        pushes(has_wall_push(constants, bodies)),
        adds(more) {
    if (pushes) push = room_for_wall_push(fluid);
  }
  KOKKOS_INLINE_FUNCTION void operator()(Index i, const Real3& change) const {
    const Real3 gained = gains ? product(diagonal(i), shear(i), change) : change;
    velocity(i) += gained;
    if (pushes) push(i) = adds ? push(i) + gained : gained;
  }
};

/// v_i += Δt L_i Σ_j F_ij/m_i.
void pull_liquid(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                 const SurfaceTensionWork& work, Real dt) {
  const Cohesion law(constants.kernel, constants.model.scene.fluid.surface_tension, constants.model.support);
  const Entries<const Real3> x = fluid.particles.position, normal = work.normal;
  const Entries<const Real> volume = fluid.volume;
  const LiquidNeighbors list(lists.fluid_fluid);
  const Uptake take(constants, bodies, fluid, false);
  const Real factor = dt / constants.rest_density;
  parallel(
      "drench::surface_tension::cohesion", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i), ni = normal(i);
        Real3 f;
        list.for_each(i, [&](Index j) {
          const Real3 r = xi - x(j);
          f += volume(j) * law.pull(r, ni - normal(j)) * r;
        });
        take(i, factor * f);
      });
}

/// v_i += Δt L_i Σ_b F_ib/m_i.
void stick_to_walls(const Constants& constants, Fluid& fluid, const Bodies& bodies, const StickyWalls& walls, Real dt) {
  const Entries<const Real3> x = fluid.particles.position;
  const Uptake take(constants, bodies, fluid, constants.model.scene.fluid.surface_tension > 0);
  const Real factor = dt / constants.rest_density;
  constexpr Real all = std::numeric_limits<Real>::max();
  parallel(
      "drench::surface_tension::adhesion", fluid.particles.count,
      KOKKOS_LAMBDA(const Index i) { take(i, factor * walls.pull(i, x(i), all)); });
}

/// The reaction on the cloth's nodes.
void pull_cloth(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Cloth& cloth,
                const SurfaceTensionWork& work, Real dt) {
  const Kernel kernel = constants.kernel;
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> force = cloth.samples.force;
  const Entries<const Real4> xs = cloth.samples.position_volume, offset = cloth.samples.normal_offset;
  const Entries<const Real> volume = fluid.volume, of_cloth = work.cloth_adhesion;
  const Entries<const Index> cloth_of = material_numbers(cloth.samples);
  const Neighbors list(lists.sample_fluid);
  parallel(
      "drench::surface_tension::sample_force", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        const Real4 at = xs(b);
        const Real3 behind = offset(b).xyz();
        list.for_each(b, [&](Index i) {
          const Real3 r = from_behind(x(i) - at.xyz(), behind);
          f -= volume(i) * kernel.grad_factor(norm(r)) * r;
        });
        force(b) = of_cloth(cloth_of(b)) * at.w * f;
      });
  fluid.exchange.share(cloth.samples.force, cloth.samples.count);
  node_forces_from_samples(cloth);
  refresh_inverse_mass(constants, cloth);
  apply_node_forces(cloth, dt);
}

}  // namespace

/// Without the strengths, a number a body and a cloth.
MemoryEstimate surface_tension_bytes(const Sizing& s) {
  MemoryEstimate sum;
  if (s.size.liquid && s.size.scene.fluid.surface_tension > 0) sum.particles = particle_room(s) * 3 * s.real;  // normal
  return sum;
}

void surface_tension(const Constants& constants, Fluid& fluid, const NeighborLists& lists, Bodies& bodies, Cloth& cloth,
                     SurfaceTensionWork& work, const StepInfo& info) {
  if (fluid.particles.total == 0) return;
  allocate(constants, fluid, work);
  const Real dt = Real(info.dt);
  const StickyWalls walls(constants, lists, bodies, cloth, work);
  if (constants.model.scene.fluid.surface_tension > 0) {
    surface_normals(constants, fluid, lists, walls, work);
    pull_liquid(constants, fluid, lists, bodies, work, dt);
  }
  if (constants.model.has_adhesion()) stick_to_walls(constants, fluid, bodies, walls, dt);
  if (has_wall_push(constants, bodies)) push_bodies_back(constants, lists, fluid, bodies);
  if (constants.model.has_sticky_cloth()) pull_cloth(constants, fluid, lists, cloth, work, dt);
}

}  // namespace drench::kokkos_backend
