// Stage cloth (law: src/stages/cloth.hpp).

#include "stages/cloth.hpp"

#include "cloth_solver.hpp"
#include "laws/wet_cloth.hpp"
#include "pins.hpp"
#include "pressure_system.hpp"
#include "rigid_bodies.hpp"

namespace drench::kokkos_backend {
namespace {

/// Target y − x⁰ with gravity and the last pressure; the iteration starts where the cloth goes by itself.
void aim(Device& d, const ClothSystem& s, Real dt, bool loaded) {
  const auto velocity = d.nodes.velocity, force = d.nodes.force;
  const auto shift = d.cloth_work.shift, last_shift = d.cloth_work.last_shift;
  const auto liquid = d.nodes.liquid;
  const auto capacity = d.nodes.capacity;
  const double quantum = d.quantum;
  const Real3 gravity = d.gravity;
  parallel(
      "drench::cloth::target", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Material& m = s.materials(s.cloth(n));
        const Real damping = at_saturation(m.damping, m.damping_wet, node_saturation(liquid(n), quantum, capacity(n)));
        const Real3 free = (dt * Kokkos::exp(-damping * dt)) * velocity(n);
        Real3 pull = gravity;
        if (loaded) pull += (1 / s.mass(n)) * force(n);
        s.target(n) = free + (dt * dt) * pull;
        shift(n) = s.pinned(n) ? Real3{} : free;
        last_shift(n) = shift(n);
      });
  if (!d.model.has_moving_pins()) return;
  const PinMotions motions(d);
  parallel(
      "drench::cloth::pins", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (motions.moves(n)) shift(n) = last_shift(n) = motions.shift(n);
      });
}

/// Velocities from the shifts, forces of contact, and the pins' reaction.
void finish(Device& d, const ClothSystem& s, Real dt, bool loaded) {
  const auto shift = d.cloth_work.shift;
  const auto velocity = d.nodes.velocity, pin_force = d.nodes.pin_force;
  const auto contact_force = d.nodes.contact_force, friction_force = d.nodes.friction_force;
  const auto force = d.nodes.force;
  const Real3 gravity = d.gravity;
  parallel(
      "drench::cloth::velocity", d.nodes.count, KOKKOS_LAMBDA(const Index n) {
        contact_force(n) = friction_force(n) = Real3{};
        const Real3 v = (1 / dt) * shift(n);
        if (s.pinned(n)) {
          const Real3 acceleration = (1 / dt) * (v - velocity(n));
          pin_force(n) -= s.elastic_force(n, shift) + s.mass(n) * (gravity - acceleration);
          if (loaded) pin_force(n) -= force(n);
          velocity(n) = v;
          return;
        }
        const NodeTerms t = s.terms(n);
        const Real3 whole = s.residual(n, shift);
        Real3 r = whole;
        if (s.contact(t, shift(n), r).press > 0) {
          contact_force(n) = r - whole;
          friction_force(n) = s.unbalanced(t, shift(n), whole) - r;
        }
        velocity(n) = v;
      });
}

}  // namespace

void cloth(Device& d, const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  const bool loaded = d.fluid.count > 0 && d.samples.count > 0;
  place_solids(d, info.dt);
  place_pins(d, info);
  if (loaded) {
    clear_inactive(d);
    cloth_forces(d);
  }
  ClothIteration iteration(d, dt);
  aim(d, iteration.system(), dt, loaded);
  iteration.run(d.model.scene.cloth_solver.max_iterations);
  iteration.line_search();
  finish(d, iteration.system(), dt, loaded);
  const ClothProgress& progress = iteration.progress();
  report.cloth_iterations = progress.iterations;
  report.cloth_residual = progress.residual;
  report.cloth_converged = progress.residual <= 1;
}

}  // namespace drench::kokkos_backend
