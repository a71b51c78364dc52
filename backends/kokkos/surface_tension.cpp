// Stage surface_tension (src/stages/surface_tension.hpp).

#include "laws/surface_tension.hpp"

#include "device.hpp"
#include "device_copy.hpp"
#include "laws/wall.hpp"

namespace drench::kokkos_backend {
namespace {

/// D of every body or cloth, on first use; stays empty where none is sticky.
template <class Parts>
void allocate_strengths(Array<Real>& strength, const char* label, const Parts& parts, const Device& d) {
  if (strength.extent(0) > 0) return;
  std::vector<double> values;
  bool any = false;
  for (const auto& part : parts) {
    values.push_back(adhesion_strength(part.adhesion, d.model.spacing, d.model.support));
    any = any || part.adhesion > 0;
  }
  if (any) strength = to_device<Real>(label, values);
}

/// Work arrays, on first use.
void allocate(Device& d) {
  SurfaceTensionWork& w = d.surface_tension_work;
  allocate_strengths(w.body_adhesion, "drench::surface_tension::body_adhesion", d.model.bodies, d);
  allocate_strengths(w.cloth_adhesion, "drench::surface_tension::cloth_adhesion", d.model.cloths, d);
  if (d.model.scene.fluid.surface_tension > 0 && w.normal.extent(0) < d.fluid.position.extent(0))
    w.normal = Array<Real3>(Kokkos::ViewAllocateWithoutInitializing("drench::surface_tension::normal"),
                            d.fluid.position.extent(0));
}

/// n_i = h Σ_j V_j ∇W_ij.
void surface_normals(Device& d) {
  const Kernel kernel = d.kernel;
  const auto x = d.fluid.position, normal = d.surface_tension_work.normal;
  const auto volume = d.work.volume;
  const Neighbors list(d.fluid_fluid);
  parallel(
      "drench::surface_tension::normal", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i);
        Real3 sum;
        const NeighborRow near = list.row(i);
        for (Index k = 0; k < near.count; ++k) {
          const Index j = near(k);
          const Real3 r = xi - x(j);
          sum += volume(j) * kernel.slope(norm(r)) * r;
        }
        normal(i) = kernel.h * sum;
      });
}

/// v_i += Δt Σ_j F_ij/m_i.
void pull_liquid(Device& d, Real dt) {
  const Cohesion law(d.kernel, d.model.scene.fluid.surface_tension, d.model.support);
  const auto x = d.fluid.position, v = d.fluid.velocity, normal = d.surface_tension_work.normal;
  const auto volume = d.work.volume;
  const Neighbors list(d.fluid_fluid);
  const Real factor = dt / d.rest_density;
  parallel(
      "drench::surface_tension::cohesion", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
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
void stick_to_walls(Device& d, const Adhesion& law, Real dt) {
  const auto x = d.fluid.position, v = d.fluid.velocity, xb = d.boundary.position;
  const auto xs = d.samples.place, back = d.samples.back;
  const auto vb = d.boundary.volume;
  const auto body = d.boundary.body, cloth_of = d.samples.cloth;
  const auto of_body = d.surface_tension_work.body_adhesion, of_cloth = d.surface_tension_work.cloth_adhesion;
  const Neighbors lb(d.fluid_boundary), ls(d.fluid_sample);
  const bool solids = of_body.extent(0) > 0 && d.boundary.count > 0;
  const bool cloth = of_cloth.extent(0) > 0 && d.samples.count > 0;
  const Real factor = dt / d.rest_density;
  parallel(
      "drench::surface_tension::adhesion", d.fluid.count, KOKKOS_LAMBDA(const Index i) {
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
        if (cloth) {
          const NeighborRow sheets = ls.row(i);
          for (Index k = 0; k < sheets.count; ++k) {
            const Index b = sheets(k);
            const Real4 at = xs(b);
            const Real3 r = from_behind(xi - at.xyz(), back(b).xyz());
            const Real length = norm(r), pull = law.value(length);
            if (pull > 0) f -= (of_cloth(cloth_of(b)) * at.w * pull / length) * r;
          }
        }
        v(i) += factor * f;
      });
}

/// The reaction on the cloth's nodes.
void pull_cloth(Device& d, const Adhesion& law, Real dt) {
  const auto x = d.fluid.position, force = d.samples.force;
  const auto xs = d.samples.place, back = d.samples.back;
  const auto volume = d.work.volume, of_cloth = d.surface_tension_work.cloth_adhesion;
  const auto cloth_of = d.samples.cloth;
  const Neighbors list(d.sample_fluid);
  parallel(
      "drench::surface_tension::sample_force", d.samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        const Real4 at = xs(b);
        const Real3 behind = back(b).xyz();
        const NeighborRow near = list.row(b);
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          const Real3 r = from_behind(x(i) - at.xyz(), behind);
          const Real length = norm(r), pull = law.value(length);
          if (pull > 0) f += (volume(i) * pull / length) * r;
        }
        force(b) = of_cloth(cloth_of(b)) * at.w * f;
      });
  node_forces_from_samples(d);
  refresh_inverse_mass(d);
  apply_node_forces(d, dt);
}

}  // namespace

void surface_tension(Device& d, const StepInfo& info, StepReport&) {
  if (d.fluid.count == 0) return;
  allocate(d);
  const Real dt = Real(info.dt);
  if (d.model.scene.fluid.surface_tension > 0) {
    surface_normals(d);
    pull_liquid(d, dt);
  }
  if (!d.model.has_adhesion()) return;
  const Adhesion law(d.model.support);
  stick_to_walls(d, law, dt);
  if (d.model.has_sticky_cloth()) pull_cloth(d, law, dt);
}

}  // namespace drench::kokkos_backend
