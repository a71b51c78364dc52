#pragma once
// How dynamic bodies answer to the cloth that touches them: the velocities at which contact and motion agree
// (docs/theory/bodies.md, Reaction of cloth).

#include "bodies/pushed_bodies.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

/// Tries velocities until those that the cloth's contact leaves are the ones that it was solved with.
class BodyReaction {
 public:
  /// Begins with the push of the last step. Nothing to do without dynamic bodies.
  BodyReaction(const Constants& constants, Bodies& bodies, const Cloth& cloth, const StepInfo& info);
  /// Takes the contact of a solve. True: bodies have another velocity to be tried, and the cloth is to be solved again.
  bool moves_on(const ClothSystem& system, const Entries<const Real3>& shift, Index nodes);
  /// By how much the last velocities disagree, in units of what is allowed.
  double disagreement() const { return disagreement_; }

 private:
  /// A body's residual, Δ(v, ω), and Aitken's factor.
  struct Answer {
    Wrench residual;
    double factor = 1;
    bool tried = false;
  };
  double size_of(const RigidBody& body, const Wrench& residual) const;
  RigidState next_try(std::size_t b, const RigidState& found);

  const Constants& constants_;
  Bodies& bodies_;
  double dt_, allowed_ = 0;  // s; m
  int solves_ = 0;
  double disagreement_ = 0;
  std::vector<RigidState> free_, tried_;  // without the cloth's pushes; as the last solve had them
  std::vector<Answer> answer_;
};

}  // namespace drench::kokkos_backend
