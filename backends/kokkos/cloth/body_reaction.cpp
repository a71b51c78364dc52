// Dynamic bodies and the cloth that they touch (docs/theory/bodies.md, Reaction of cloth).

#include "cloth/body_reaction.hpp"

#include <algorithm>

#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int most_solves = 12;
constexpr double allowed_part = 0.001;  // of the thinnest cloth: a tenth of the width of contact

Wrench difference(const RigidState& a, const RigidState& b) {
  return {minus(a.velocity, b.velocity), minus(a.spin, b.spin)};
}

/// Its impulses on the solids, of a node that presses on some: what they do to it, the other way round.
struct NodePushes {
  ClothSystem system;
  PushesOnBodies pushes;
  Entries<const Real3> shift;

  KOKKOS_INLINE_FUNCTION void operator()(const Index n) const {
    if (system.pinned(n)) return;
    const NodeTerms t = system.terms(n);
    const Real3 whole = system.residual(n, shift);
    Real3 left = whole;
    const NodeContact<> c = system.contact(t, shift(n), left, t.compression,
                                           [&](const std::size_t solid, const Real3& force) { push(solid, n, force); });
    if (!(c.press > 0)) return;
    // Friction, shared by the solids as they press.
    const Real3 friction = left - system.unbalanced(t, shift(n), whole);
    left = whole;
    system.contact(t, shift(n), left, t.compression, [&](const std::size_t solid, const Real3& force) {
      push(solid, n, (norm(force) / c.press) * friction);
    });
  }
  KOKKOS_INLINE_FUNCTION void push(std::size_t solid, Index n, const Real3& force) const {
    const Solid& s = system.solids(solid);
    const auto b = static_cast<std::size_t>(s.body);
    if (!pushes.takes(b)) return;
    const Real3 arm = (system.start(n) - s.center) + shift(n);
    pushes.add(b, widen(arm), times(double(system.dt), widen(force)));
  }
};

/// The forces of the last step, each as a push on the last dynamic body that the node is next to.
struct LastPushes {
  Entries<const Real3> position, contact, friction;
  Materials material;
  Slice<const Solid> solids;
  PushesOnBodies pushes;
  double dt;

  LastPushes(const Constants& constants, Bodies& bodies, const Cloth& cloth, double step)
      : position(cloth.nodes.position),
        contact(cloth.nodes.contact_force),
        friction(cloth.nodes.friction_force),
        material(node_materials(cloth)),
        solids(bodies.solids),
        pushes(constants, bodies),
        dt(step) {}
  KOKKOS_INLINE_FUNCTION void operator()(const Index n) const {
    const Real3 force = contact(n) + friction(n);
    if (!(dot(force, force) > 0)) return;
    std::size_t touched = solids.extent(0);
    for (std::size_t b = 0; b < solids.extent(0); ++b)
      if (solid_distance(solids(b), position(n), Real3{}).phi < 2 * material(n).thickness) touched = b;
    if (touched == solids.extent(0)) return;
    const auto b = static_cast<std::size_t>(solids(touched).body);
    if (pushes.takes(b)) pushes.add(b, widen(position(n) - solids(touched).center), times(-dt, widen(force)));
  }
};

void add_last_pushes(const Constants& constants, Bodies& bodies, const Cloth& cloth, const StepInfo& info) {
  place_solids(constants, bodies, info);
  clear_pushes(bodies);
  const LastPushes last(constants, bodies, cloth, info.dt);
  parallel(
      "drench::cloth::last_pushes", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) { last(n); });
}

}  // namespace

BodyReaction::BodyReaction(const Constants& constants, Bodies& bodies, const Cloth& cloth, const StepInfo& info)
    : constants_(constants), bodies_(bodies), dt_(info.dt) {
  if (!constants.model.cloth_pushes_bodies()) return;
  free_ = tried_ = to_host<RigidState>(bodies.state, bodies.count);
  answer_.resize(free_.size());
  allowed_ = 1e300;
  constants.model.for_materials(
      [&](const ClothMaterial& c) { allowed_ = std::min(allowed_, allowed_part * c.thickness); });
  add_last_pushes(constants, bodies, cloth, info);
  const std::vector<Wrench> last = pushes_on(constants, bodies);
  for (std::size_t b = 0; b < free_.size(); ++b) tried_[b] = pushed(bodies.constant_on_host[b], free_[b], last[b]);
  set_states(bodies, tried_);
}

double BodyReaction::size_of(const RigidBody& body, const Wrench& r) const {
  return dt_ * (std::sqrt(inner(r.force, r.force)) + body.reach * std::sqrt(inner(r.torque, r.torque)));
}

/// Aitken's relaxation of the fixed point (Küttler and Wall 2008), in the metric of the kinetic energy.
RigidState BodyReaction::next_try(std::size_t b, const RigidState& found) {
  const RigidBody& body = bodies_.constant_on_host[b];
  Answer& a = answer_[b];
  const Wrench now = difference(found, tried_[b]);
  if (a.tried) {
    const Wrench change{minus(now.force, a.residual.force), minus(now.torque, a.residual.torque)};
    const Double3 turn = times_inertia(body, found.orientation, change.torque);
    const double square = inner(change.force, change.force) / body.inverse_mass + inner(change.torque, turn);
    const double along = inner(a.residual.force, change.force) / body.inverse_mass + inner(a.residual.torque, turn);
    if (square > 0) a.factor = std::clamp(-a.factor * along / square, 0.001, 1.0);
  }
  a.residual = now;
  a.tried = true;
  RigidState next = tried_[b];
  next.velocity = add(next.velocity, times(a.factor, now.force));
  next.spin = add(next.spin, times(a.factor, now.torque));
  return next;
}

bool BodyReaction::moves_on(const ClothSystem& system, const Entries<const Real3>& shift, Index nodes) {
  if (free_.empty()) return false;
  clear_pushes(bodies_);
  const NodePushes pushes{system, PushesOnBodies(constants_, bodies_), shift};
  parallel(
      "drench::cloth::pushes", nodes, KOKKOS_LAMBDA(const Index n) { pushes(n); });
  const std::vector<Wrench> impulse = pushes_on(constants_, bodies_);
  std::vector<RigidState> found;
  disagreement_ = 0;
  for (std::size_t b = 0; b < free_.size(); ++b) {
    found.push_back(pushed(bodies_.constant_on_host[b], free_[b], impulse[b]));
    if (bodies_.constant_on_host[b].dynamic)
      disagreement_ =
          std::max(disagreement_, size_of(bodies_.constant_on_host[b], difference(found[b], tried_[b])) / allowed_);
  }
  if (disagreement_ <= 1 || ++solves_ >= most_solves) {
    set_states(bodies_, found);
    add_impulses(bodies_.given_by_cloth, impulse);
    return false;
  }
  for (std::size_t b = 0; b < free_.size(); ++b)
    if (bodies_.constant_on_host[b].dynamic) tried_[b] = next_try(b, found[b]);
  set_states(bodies_, tried_);
  return true;
}

}  // namespace drench::kokkos_backend
