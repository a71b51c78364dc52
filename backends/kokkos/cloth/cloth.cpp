// Stage cloth (law: src/stages/cloth.hpp).

#include "stages/cloth.hpp"

#include <algorithm>
#include <optional>

#include "cloth/body_reaction.hpp"
#include "cloth/pins.hpp"
#include "cloth/stages.hpp"
#include "cloth/wet_cloth.hpp"

namespace drench::kokkos_backend {
namespace {

/// Target y − x⁰ with gravity and the last pressure; the iteration starts where the cloth goes by itself, or where the
/// solve before has led (`again`).
void aim(const Constants& constants, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, Real dt,
         bool loaded, bool again) {
  const Entries<const Real3> velocity = cloth.nodes.velocity, force = cloth.nodes.force;
  const Entries<Real3> shift = solver.displacement, last_shift = solver.last_displacement;
  const NodeLiquid wet(constants, cloth);
  const Real3 gravity = constants.gravity;
  const SoftPins soft(cloth);
  parallel(
      "drench::cloth::target", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        const Real damping = damping_at(s.materials(n), wet, n);
        const Real3 free = (dt * Kokkos::exp(-damping * dt)) * velocity(n);
        const Real held = soft(n) * (dt * dt) / s.mass(n);  // share of a soft pin in m_n + K Δt²
        Real3 pull = (1 - held) * gravity;
        if (loaded) pull += (1 / s.mass(n)) * force(n);
        s.target(n) = (1 - held) * free + (dt * dt) * pull;
        if (held > 0) s.target(n) += held * (soft.motions.position(n) - s.start(n));
        if (!again) shift(n) = s.pinned(n) ? Real3{} : free;
        last_shift(n) = shift(n);
      });
  if (!constants.model.has_moving_pins()) return;
  const PinMotions motions(cloth);
  parallel(
      "drench::cloth::pins", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n) && motions.moves(n)) shift(n) = last_shift(n) = motions.shift(n);
      });
}

/// Velocities from the shifts, forces of contact, and the pins' reaction.
void finish(const Constants& constants, Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, Real dt,
            bool loaded) {
  const Entries<const Real3> shift = solver.displacement;
  const Entries<Real3> velocity = cloth.nodes.velocity, pin_force = cloth.nodes.pin_force;
  const Entries<Real3> contact_force = cloth.nodes.contact_force, friction_force = cloth.nodes.friction_force;
  const Entries<const Real3> force = cloth.nodes.force;
  const Real3 gravity = constants.gravity;
  const SoftPins soft(cloth);
  parallel(
      "drench::cloth::velocity", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        contact_force(n) = friction_force(n) = Real3{};
        const Real3 v = (1 / dt) * shift(n);
        if (s.pinned(n)) {
          const Real3 acceleration = (1 / dt) * (v - velocity(n));
          pin_force(n) -= s.elastic_force(n, shift) + s.mass(n) * (gravity - acceleration);
          if (loaded) pin_force(n) -= force(n);
          velocity(n) = v;
          return;
        }
        velocity(n) = v;
        if (soft(n) > 0) pin_force(n) += soft.force(n, s.start(n) + shift(n));
        const NodeTerms t = s.terms(n);
        Real3 nothing{};  // most nodes touch nothing, and the residual of the others is long to evaluate
        if (!s.contact(t, shift(n), nothing, t.compression).touches) return;
        const Real3 whole = s.residual(n, shift);
        Real3 r = whole;
        if (s.contact(t, shift(n), r, t.compression).press > 0) {
          contact_force(n) = r - whole;
          friction_force(n) = s.unbalanced(t, shift(n), whole) - r;
        }
      });
}

}  // namespace

void cloth(const Constants& constants, Bodies& bodies, Cloth& cloth, ClothSolverWork& solver, bool loaded,
           const StepInfo& info, StepReport& report) {
  const Real dt = static_cast<Real>(info.dt);
  place_pins(constants, cloth, info);
  shorten_stitches(cloth, info);
  BodyReaction reaction(constants, bodies, cloth, info);
  std::optional<ClothIteration> iteration;
  report.cloth_iterations = 0;
  do {
    place_solids(constants, bodies, info);
    const bool again = iteration.has_value();
    iteration.emplace(constants, bodies, cloth, solver, dt);
    aim(constants, cloth, solver, iteration->system(), dt, loaded, again);
    iteration->end_early_for_host();
    iteration->run(constants.model.scene.cloth_solver.max_iterations);
    iteration->finish_on_host();
    iteration->line_search();
    report.cloth_iterations += iteration->progress().iterations;
  } while (reaction.moves_on(iteration->system(), solver.displacement, cloth.nodes.count));
  finish(constants, cloth, solver, iteration->system(), dt, loaded);
  report.cloth_residual = std::max(iteration->progress().residual, reaction.disagreement());
  report.cloth_converged = report.cloth_residual <= 1;
}

}  // namespace drench::kokkos_backend
