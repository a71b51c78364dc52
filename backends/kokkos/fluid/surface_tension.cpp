// Stage surface_tension (src/stages/surface_tension.hpp).

#include "fluid/surface_tension_law.hpp"

#include "core/host_copy.hpp"
#include "coupling/wall.hpp"
#include "fluid/stages.hpp"

namespace drench::kokkos_backend {
namespace {

/// D of every body or cloth, on first use; stays empty where none is sticky.
template <class Parts>
void allocate_strengths(Field<Real>& strength, const char* label, const Parts& parts, const Constants& constants) {
  if (strength.extent(0) > 0) return;
  std::vector<double> values;
  bool any = false;
  for (const auto& part : parts) {
    values.push_back(adhesion_strength(part.adhesion, constants.model.spacing, constants.model.support));
    any = any || part.adhesion > 0;
  }
  if (any) strength = to_device<Real>(label, values);
}

/// Work arrays, on first use.
void allocate(const Constants& constants, const Fluid& fluid, SurfaceTensionWork& work) {
  allocate_strengths(work.body_adhesion, "drench::surface_tension::body_adhesion", constants.model.bodies, constants);
  allocate_strengths(work.cloth_adhesion, "drench::surface_tension::cloth_adhesion", constants.model.cloths, constants);
  if (constants.model.scene.fluid.surface_tension > 0)
    make_room(work.normal, "drench::surface_tension::normal", fluid.particles.capacity());
}

/// n_i = h Σ_j V_j ∇W_ij.
void surface_normals(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, SurfaceTensionWork& work) {
  const Kernel kernel = constants.kernel;
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> normal = work.normal;
  const Entries<const Real> volume = fluid.volume;
  const Neighbors list(lists.fluid_fluid);
  parallel(
      "drench::surface_tension::normal", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i);
        Real3 sum;
        const NeighborRow near = list.row(i);
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real3 r = xi - x(j);
          sum += volume(j) * kernel.grad_factor(norm(r)) * r;
        }
        normal(i) = kernel.h * sum;
      });
}

/// v_i += Δt Σ_j F_ij/m_i.
void pull_liquid(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const SurfaceTensionWork& work, Real dt) {
  const Cohesion law(constants.kernel, constants.model.scene.fluid.surface_tension, constants.model.support);
  const Entries<const Real3> x = fluid.particles.position, normal = work.normal;
  const Entries<Real3> v = fluid.particles.velocity;
  const Entries<const Real> volume = fluid.volume;
  const Neighbors list(lists.fluid_fluid);
  const Real factor = dt / constants.rest_density;
  parallel(
      "drench::surface_tension::cohesion", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i), ni = normal(i);
        Real3 f;
        const NeighborRow near = list.row(i);
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real3 r = xi - x(j);
          f += volume(j) * law.pull(r, ni - normal(j)) * r;
        }
        v(i) += factor * f;
      });
}

/// v_i += Δt Σ_b F_ib/m_i.
void stick_to_walls(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies, const Cloth& cloth, const SurfaceTensionWork& work, const Adhesion& law, Real dt) {
  const Entries<const Real3> x = fluid.particles.position, xb = bodies.boundary.position;
  const Entries<Real3> v = fluid.particles.velocity;
  const Entries<const Real4> xs = cloth.samples.position_volume, offset = cloth.samples.normal_offset;
  const Entries<const Real> vb = bodies.boundary.volume;
  const Entries<const Index> body = bodies.boundary.body, cloth_of = cloth.samples.cloth;
  const Slice<const Real> of_body = work.body_adhesion, of_cloth = work.cloth_adhesion;
  const Neighbors lb(lists.fluid_boundary), ls(lists.fluid_sample);
  const bool solids = of_body.extent(0) > 0 && bodies.boundary.count > 0;
  const bool sheets = of_cloth.extent(0) > 0 && cloth.samples.count > 0;
  const Real factor = dt / constants.rest_density;
  parallel(
      "drench::surface_tension::adhesion", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i);
        Real3 f;
        if (solids) {
          const NeighborRow walls = lb.row(i);
          for (Index k = 0; k < walls.count; ++k) {
            const Index b = walls(k);
            const Real3 r = xi - xb(b);
            const Real length = norm(r), pull = law.value(length);
            if (pull > 0) f -= (of_body(body(b)) * vb(b) * pull / length) * r;
          }
        }
        if (sheets) {
          const NeighborRow cloths = ls.row(i);
          for (Index k = 0; k < cloths.count; ++k) {
            const Index b = cloths(k);
            const Real4 at = xs(b);
            const Real3 r = from_behind(xi - at.xyz(), offset(b).xyz());
            const Real length = norm(r), pull = law.value(length);
            if (pull > 0) f -= (of_cloth(cloth_of(b)) * at.w * pull / length) * r;
          }
        }
        v(i) += factor * f;
      });
}

/// The reaction on the cloth's nodes.
void pull_cloth(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, Cloth& cloth, const SurfaceTensionWork& work, const Adhesion& law, Real dt) {
  const Entries<const Real3> x = fluid.particles.position;
  const Entries<Real3> force = cloth.samples.force;
  const Entries<const Real4> xs = cloth.samples.position_volume, offset = cloth.samples.normal_offset;
  const Entries<const Real> volume = fluid.volume, of_cloth = work.cloth_adhesion;
  const Entries<const Index> cloth_of = cloth.samples.cloth;
  const Neighbors list(lists.sample_fluid);
  parallel(
      "drench::surface_tension::sample_force", cloth.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        const Real4 at = xs(b);
        const Real3 behind = offset(b).xyz();
        const NeighborRow near = list.row(b);
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          const Real3 r = from_behind(x(i) - at.xyz(), behind);
          const Real length = norm(r), pull = law.value(length);
          if (pull > 0) f += (volume(i) * pull / length) * r;
        }
        force(b) = of_cloth(cloth_of(b)) * at.w * f;
      });
  node_forces_from_samples(cloth);
  refresh_inverse_mass(constants, cloth);
  apply_node_forces(cloth, dt);
}

}  // namespace

void surface_tension(const Constants& constants, Fluid& fluid, const NeighborLists& lists, const Bodies& bodies,
                     Cloth& cloth, SurfaceTensionWork& work, const StepInfo& info) {
  if (fluid.particles.count == 0) return;
  allocate(constants, fluid, work);
  const Real dt = Real(info.dt);
  if (constants.model.scene.fluid.surface_tension > 0) {
    surface_normals(constants, fluid, lists, work);
    pull_liquid(constants, fluid, lists, work, dt);
  }
  if (!constants.model.has_adhesion()) return;
  const Adhesion law(constants.model.support);
  stick_to_walls(constants, fluid, lists, bodies, cloth, work, law, dt);
  if (constants.model.has_sticky_cloth()) pull_cloth(constants, fluid, lists, cloth, work, law, dt);
}

}  // namespace drench::kokkos_backend
