#pragma once
// Contacts and hinges of dynamic bodies, by Bullet: docs/theory/bodies.md, Contact, Hinges.

#include <memory>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// A body where it is, and how it moves: m, m/s, rad/s.
struct RigidMotion {
  Vec3 position{0, 0, 0}, velocity{0, 0, 0}, spin{0, 0, 0};
  Quaternion orientation{1, 0, 0, 0};
};

/// What the other bodies and hinges did to one in a step.
struct ContactImpulse {
  bool touched = false;                     // was there any contact or hinge?
  Vec3 impulse{0, 0, 0}, turning{0, 0, 0};  // kg m/s; kg m²/s, about the centre at the start of the step
};

class RigidContacts {
 public:
  /// Keeps references to the model's bodies and joints. Half-spaces and the outsides of containers are solid as far as
  /// the domain is wide.
  explicit RigidContacts(const Model& model);
  ~RigidContacts();
  RigidContacts(const RigidContacts&) = delete;
  RigidContacts& operator=(const RigidContacts&) = delete;

  /// Over `dt` until `end` (s): dynamic bodies that touch something or hang on a hinge get the pose of the end of the
  /// step and their velocities after it; all others stay as given. `motion` of each body: its pose at the start of the
  /// step and its velocities, of dynamic ones with all forces of the step in them; `share`: StepInfo::correction_share,
  /// of overlaps. Nothing is kept from one step to the next.
  std::vector<ContactImpulse> advance(std::vector<RigidMotion>& motion, double dt, double end, double share = 1);

  /// Does a dynamic body touch another, or hang on a hinge, in these poses of the start of a step?
  bool touches(const std::vector<RigidMotion>& motion, double dt, double end);
  /// What advance() would do to the velocities alone, without bounce: `motion` gets those of dynamic bodies that touch
  /// something or hang on a hinge.
  void hold(std::vector<RigidMotion>& motion, double dt, double end, double share);

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace drench
