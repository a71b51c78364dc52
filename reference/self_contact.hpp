#pragma once
// Contacts of the cloth with itself inside its implicit step (docs/theory/contacts.md, section 8).

#include "collision.hpp"
#include "proximity.hpp"

namespace drench::reference {

/// A pair that may touch in this step: a spring that only presses, and its friction.
struct SelfContact {
  Pair pair;
  std::array<double, 4> b;
  Eigen::Vector3d normal;
  double short_of;   // γ less n·Σ b x⁰, m
  double stiffness;  // k_c, N/m

  /// Of the nodes' displacements (m): what acts on the first of the two; b_k times this acts on node k, N.
  Eigen::Vector3d force(const Four& moved) const;
};

/// Those of the paths by the nodes' velocities; none unless the scene asks for them.
std::vector<SelfContact> self_contacts(const ReferenceState& state, const StepInfo& info,
                                       const std::vector<PlacedBody>& bodies);

}  // namespace drench::reference
