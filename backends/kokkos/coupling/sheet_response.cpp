#include "coupling/sheet_response.hpp"

#include "core/gather.hpp"

namespace drench::kokkos_backend {
namespace {

/// Nodes that do no more than note what loads them.
struct NoAnswer {
  KOKKOS_INLINE_FUNCTION void operator()(Index, const Real3&) const {}
};
struct FreeNodes {
  Entries<Real3> predicted;
  Entries<const Real3> contact, velocity;
  Entries<const Real> inverse_mass;
  Real dt;

  FreeNodes(Cloth& cloth, Real step)
      : predicted(cloth.nodes.predicted),
        contact(std::as_const(cloth).nodes.contact_force),
        velocity(std::as_const(cloth).nodes.velocity),
        inverse_mass(std::as_const(cloth).nodes.inverse_mass),
        dt(step) {}
  KOKKOS_INLINE_FUNCTION void operator()(Index n, const Real3& f) const {
    const Real square = dot(contact(n), contact(n)), into = dot(f, contact(n));
    predicted(n) = velocity(n) + (dt * inverse_mass(n)) * (into < 0 ? f - (into / square) * contact(n) : f);
  }
};

/// finish(n, f_n) for each node.
template <class Finish>
void gather_forces(const SheetLoad& load, const char* label, const Cloth& cloth, const Finish& finish) {
  const SheetRows& rows = load.rows;
  if (rows.count == 0)
    return parallel(
        label, cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { finish(n, Real3{}); });
  const Entries<const SheetPair> pair = rows.node_pair;
  const Entries<const Real> kappa = load.pressure;
  const bool touching = load.contact_pressure != nullptr;
  const Entries<const Real> contact =
      touching ? Entries<const Real>(std::as_const(*load.contact_pressure)) : Entries<const Real>();
  gather_rows<Real3>(
      label, cloth.nodes.count, rows.of_node,
      KOKKOS_LAMBDA(const Index e) {
        const SheetPair near = pair(e);
        const Real k = touching ? kappa(near.other) + contact(near.other) : kappa(near.other);
        return k * near.gradient;
      },
      finish);
}

/// nodes.force = f_n, and answer(n, f_n); alone in one kernel. Among ranks the one that owns a node's place has all of
/// its pairs.
template <class Answer>
void load_nodes(const SheetLoad& load, Cloth& cloth, const Answer& answer) {
  constexpr const char* label = "drench::pressure::node_force";
  const Entries<Real3> f = cloth.nodes.force;
  if (load.exchange.alone())
    return gather_forces(
        load, label, cloth, KOKKOS_LAMBDA(const Index n, const Real3& sum) {
          f(n) = sum;
          answer(n, sum);
        });
  if (load.contact_pressure != nullptr) load.exchange.halo(*load.contact_pressure);
  const RankBox own = load.exchange.own();
  const Entries<const Real3> x = std::as_const(cloth).nodes.position;
  gather_forces(
      load, label, cloth, KOKKOS_LAMBDA(const Index n, const Real3& sum) { f(n) = own.holds(x(n)) ? sum : Real3{}; });
  load.exchange.share(cloth.nodes.force, cloth.nodes.count);
  parallel(
      "drench::pressure::node_answer", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { answer(n, f(n)); });
}

}  // namespace

void warm_start_density(Fluid& fluid, PressureWork& work) {
  allocate_pressure_work(work, fluid);
  const Entries<Real> kappa = fluid.particles.kappa_density;
  const Entries<const Real> alpha = std::as_const(fluid.alpha);
  parallel(
      "drench::pressure::warm_start", fluid.particles.count, KOKKOS_LAMBDA(const Index i) {
        if (alpha(i) == 0) kappa(i) = 0;
      });
}

void load_cloth(const SheetLoad& load, Cloth& cloth) { load_nodes(load, cloth, NoAnswer{}); }
void load_free_cloth(const SheetLoad& load, Cloth& cloth, Real dt) { load_nodes(load, cloth, FreeNodes(cloth, dt)); }
void load_elastic_cloth(const SheetLoad& load, Cloth& cloth, const NodeTargets& targets) {
  load_nodes(load, cloth, targets);
}

void accept_free_cloth(Cloth& cloth) {
  const Entries<Real3> vn = cloth.nodes.velocity, pin = cloth.nodes.pin_force;
  const Nodes& nodes = cloth.nodes;
  const Entries<const Real3> predicted = nodes.predicted, f = nodes.force;
  const Entries<const std::uint8_t> fixed = nodes.fixed;
  parallel(
      "drench::pressure::accept_nodes", nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (fixed(n))
          pin(n) -= f(n);
        else
          vn(n) = predicted(n);
      });
}

}  // namespace drench::kokkos_backend
