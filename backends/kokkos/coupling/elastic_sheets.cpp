#include "coupling/elastic_sheets.hpp"

#include "cloth/pins.hpp"
#include "stages/pressure.hpp"

namespace drench::kokkos_backend {

ElasticSheets::ElasticSheets(const Constants& constants, const Bodies& bodies, Cloth& cloth, ClothSolverWork& solver,
                             Real dt)
    : cloth_(cloth),
      solver_(solver),
      dt_(dt),
      limits_(constants.model.scene.cloth_solver),
      iteration_(constants, bodies, cloth, solver, dt) {}

void ElasticSheets::start() {
  const Real dt = dt_;
  const ClothSystem s = iteration_.system();
  const Nodes& nodes = cloth_.nodes;
  const Entries<const Real3> v = nodes.velocity, f = nodes.force, contact = nodes.contact_force,
                             friction = nodes.friction_force;
  const Entries<Real3> pin = cloth_.nodes.pin_force, base = solver_.base, shift = solver_.displacement,
                       last = solver_.last_displacement;
  // In double on a host, as its iterations see the elastic forces (cloth/exact_residual.hpp).
  using Number = std::conditional_t<on_host, double, Real>;
  const auto start = KOKKOS_LAMBDA(const Index n) { return in_precision<Number>(dt * v(n)); };
  parallel(
      "drench::pressure::cloth_base", nodes.count, KOKKOS_LAMBDA(const Index n) {
        shift(n) = last(n) = dt * v(n);
        const Vector3<Number> elastic = s.elastic_force(n, start);
        const Vector3<Number> force = elastic + in_precision<Number>(f(n));
        if (s.pinned(n)) {
          pin(n) += Real3{Real(force.x), Real(force.y), Real(force.z)};
          return;
        }
        const Vector3<Number> all = force + in_precision<Number>(contact(n) + friction(n));
        const Real3 change = (dt * dt / s.mass(n)) * Real3{Real(all.x), Real(all.y), Real(all.z)};
        base(n) = shift(n) - change;
      });
}

NodeTargets ElasticSheets::targets() {
  const ClothSystem s = iteration_.system();
  return {s.target, std::as_const(solver_).base, s.mass, s.pinned, dt_};
}

void ElasticSheets::respond() {
  const int most = cloth_iterations_per_pressure(limits_, 0);
  // A GPU may still be at the last ones: how many it took matters, and is waited for, only near the limit.
  if (cloth_iterations_per_pressure(limits_, granted_) < most) granted_ = iteration_.progress().iterations;
  const int next = cloth_iterations_per_pressure(limits_, granted_);
  granted_ += next;
  iteration_.run(next);
}

void ElasticSheets::accept() {
  iteration_.line_search();
  const ClothSystem s = iteration_.system();
  const Real dt = dt_;
  const Entries<Real3> v = cloth_.nodes.velocity, pin = cloth_.nodes.pin_force;
  const Entries<const Real3> f = std::as_const(cloth_).nodes.force, shift = std::as_const(solver_).displacement;
  const SoftPins soft(cloth_);
  parallel(
      "drench::pressure::accept_cloth", cloth_.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n))
          pin(n) -= s.elastic_force(n, shift) + f(n);
        else {
          if (soft(n) > 0) pin(n) += soft(n) * (dt * v(n) - shift(n));
          v(n) = (1 / dt) * shift(n);
        }
      });
}

}  // namespace drench::kokkos_backend
