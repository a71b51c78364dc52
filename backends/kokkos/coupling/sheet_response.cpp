#include "coupling/sheet_response.hpp"

#include "core/gather.hpp"

namespace drench::kokkos_backend {

void warm_start_density(Fluid& fluid, PressureWork& work) {
  allocate_pressure_work(work, fluid);
  const Entries<Real> kappa = fluid.particles.kappa_density;
  const Entries<const Real> alpha = std::as_const(fluid.alpha);
  parallel(
      "drench::pressure::warm_start", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        if (alpha(i) == 0) kappa(i) = 0;
      });
}

void load_cloth(const SheetRows& rows, const Field<Real>& pressure, const Field<Real>* contact_pressure, Cloth& cloth) {
  const Entries<Real3> f = cloth.nodes.force;
  if (rows.count == 0) {
    Kokkos::deep_copy(ExecSpace(), cloth.nodes.force, Real3{});
    return;
  }
  const Entries<const SheetPair> pair = rows.node_pair;
  const Entries<const Real> kappa = pressure;
  const bool touching = contact_pressure != nullptr;
  const Entries<const Real> contact = touching ? Entries<const Real>(*contact_pressure) : Entries<const Real>();
  gather_rows<Real3>(
      "drench::pressure::node_force", cloth.nodes.count, rows.of_node,
      KOKKOS_LAMBDA(const Index e) {
        const SheetPair near = pair(e);
        const Real k = touching ? kappa(near.other) + contact(near.other) : kappa(near.other);
        return k * near.gradient;
      },
      KOKKOS_LAMBDA(const Index n, const Real3& sum) { f(n) = sum; });
}

void predict_free_cloth(Cloth& cloth, Real dt) {
  const Entries<Real3> predicted = cloth.nodes.predicted;
  const Nodes& nodes = cloth.nodes;
  const Entries<const Real3> f = nodes.force, contact = nodes.contact_force, v = nodes.velocity;
  const Entries<const Real> u = nodes.inverse_mass;
  parallel(
      "drench::pressure::node_velocity", nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real square = dot(contact(n), contact(n)), into = dot(f(n), contact(n));
        predicted(n) = v(n) + (dt * u(n)) * (into < 0 ? f(n) - (into / square) * contact(n) : f(n));
      });
}

void accept_free_cloth(Cloth& cloth) {
  const Entries<Real3> vn = cloth.nodes.velocity, pin = cloth.nodes.pin_force;
  const Nodes& nodes = cloth.nodes;
  const Entries<const Real3> predicted = nodes.predicted, f = nodes.force;
  const Entries<const std::uint8_t> pinned = nodes.pinned;
  parallel(
      "drench::pressure::accept_nodes", nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (pinned(n))
          pin(n) -= f(n);
        else
          vn(n) = predicted(n);
      });
}

}  // namespace drench::kokkos_backend
