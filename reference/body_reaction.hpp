#pragma once
// How dynamic bodies answer to the cloth that touches them (docs/theory/bodies.md, Reaction of cloth).

#include "cloth_problem.hpp"
#include "rigid_bodies.hpp"

namespace drench::reference {

/// The fixed point of bodies' velocities and the contact of cloth that is solved with them.
class BodyReaction {
 public:
  /// Begins with the push of the last step.
  BodyReaction(ReferenceState& state, const StepInfo& info);
  /// True: the state's bodies have another velocity to be tried.
  bool moves_on(const ClothProblem& problem, const Vectors& x);
  double disagreement() const { return disagreement_; }

 private:
  struct Tried {
    Pose free;               // without the cloth's pushes
    Six velocity, residual;  // as the last solve had it; what that disagreed by
    double factor = 1;
    int times = 0;
  };
  std::vector<Six> last_impulses(const StepInfo& info) const;
  std::vector<Six> impulses(const ClothProblem& problem, const Vectors& x) const;
  Six next(Index body, const Six& found);

  ReferenceState& state_;
  double dt_, allowed_ = 1e300, disagreement_ = 0;
  int solves_ = 0;
  std::vector<Tried> tried_;
};

}  // namespace drench::reference
