#include "coupling/sheet_response.hpp"

namespace drench::kokkos_backend {

void warm_start_density(Fluid& fluid, const Cloth& cloth, PressureWork& work) {
  allocate_pressure_work(work, fluid);
  const Entries<Real> kappa = fluid.particles.kappa_density;
  const Entries<const Real> alpha = std::as_const(fluid.alpha), ratio = std::as_const(fluid.particles.density_ratio),
                            volume = std::as_const(fluid.volume);
  const Entries<Real4> predicted = work.predicted;
  const bool sheets = cloth.samples.count > 0;
  parallel(
      "drench::pressure::warm_start", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        if (alpha(i) == 0) kappa(i) = 0;
        if (sheets) predicted(i).w = sheet_load(ratio(i), volume(i), kappa(i));
      });
}

void load_cloth(const Constants& constants, const Fluid& fluid, const NeighborLists& lists, const PressureWork& work,
                Cloth& cloth) {
  const Kernel kernel = constants.kernel;
  const Real rho = constants.rest_density;
  const Samples& samples = cloth.samples;
  const Entries<const Real4> xs = samples.position_volume, offset = samples.normal_offset, xf = fluid.position_volume,
                             predicted = work.predicted;
  const Entries<Real3> force = cloth.samples.force;
  const Neighbors list(lists.sample_fluid);
  parallel(
      "drench::pressure::sample_force", samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 f;
        const Real4 at = xs(b);
        const Real3 behind = offset(b).xyz();
        const NeighborRow near = list.row(b);
        DRENCH_UNROLL
        for (Index k = 0; k < near.count; ++k) {
          const Index i = near(k);
          const Real load = predicted(i).w;
          if (on_host && load == 0) continue;  // a GPU is quicker without a branch between the loads
          f += load * kernel.gradient(from_behind(xf(i).xyz() - at.xyz(), behind));
        }
        force(b) = (mirrored * rho * at.w) * f;
      });
  node_forces_from_samples(cloth);
}

void predict_free_cloth(Cloth& cloth, Real dt) {
  const Entries<Real3> a = cloth.nodes.acceleration;
  const Nodes& nodes = cloth.nodes;
  const Samples& samples = cloth.samples;
  const Entries<const Real3> f = nodes.force, contact = nodes.contact_force, v = nodes.velocity;
  const Entries<const Real> u = nodes.inverse_mass, weight = samples.weight;
  parallel(
      "drench::pressure::node_acceleration", nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real square = dot(contact(n), contact(n)), into = dot(f(n), contact(n));
        a(n) = u(n) * (into < 0 ? f(n) - (into / square) * contact(n) : f(n));
      });
  const Entries<const Index> node = samples.node;
  const Entries<Real4> predicted = cloth.samples.predicted;
  parallel(
      "drench::pressure::sample_velocity", samples.count, KOKKOS_LAMBDA(const Index b) {
        Real3 p;
        for (int k = 0; k < 3; ++k) {
          const Index n = node(3 * b + k);
          p += weight(3 * b + k) * (v(n) + dt * a(n));
        }
        predicted(b) = {p, Real(0)};
      });
}

void accept_free_cloth(Cloth& cloth, Real dt) {
  const Entries<Real3> vn = cloth.nodes.velocity, pin = cloth.nodes.pin_force;
  const Nodes& nodes = cloth.nodes;
  const Entries<const Real3> a = nodes.acceleration, f = nodes.force;
  const Entries<const std::uint8_t> pinned = nodes.pinned;
  parallel(
      "drench::pressure::accept_nodes", nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (pinned(n))
          pin(n) -= f(n);
        else
          vn(n) += dt * a(n);
      });
}

}  // namespace drench::kokkos_backend
