#pragma once
// What a scene prescribes and a program may change between two steps: the velocity of pins, jets and wind, the motion
// of bodies and what acts on them, the speed of motors, the nodes that are attached to bodies. Each change is
// continuous: pins and bodies go on from where they are, a jet from the liquid that it has let go.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Of a body.
struct BodyCommand {
  CommandedMotion motion;
  Vec3 force{0, 0, 0}, torque{0, 0, 0};  // N, N m
};

/// All that these changes change. A copy of it brings a model back.
struct Prescribed {
  std::vector<PinMotion> pin_motions;
  std::vector<Index> pin_motion;
  std::vector<std::uint8_t> pinned;
  std::vector<Jet> jets;
  WindScene wind;
  std::vector<BodyCommand> bodies;
  std::vector<Keyed<double>> motors;  // of each joint, rad/s
  double fastest_before = 0;          // m/s
};
Prescribed prescribed_of(const Model& model);
void prescribe(Model& model, const Prescribed& prescribed);

/// std::invalid_argument: there is no such cloth.
const ClothMaterial& cloth_numbered(const Model& model, Index cloth);
/// The nodes of entry `entry` in `cloth.N.pin`. std::invalid_argument: there is no such cloth or entry, or it holds no
/// node.
std::vector<Index> nodes_of_pin(const Model& model, Index cloth, Index entry);

/// From `time` (s) on the pins of entry `entry` in `cloth.N.pin` move at `velocity`, m/s, and do not turn.
/// std::invalid_argument: no such cloth or entry, an entry that holds no node, a cloth that does not move, no finite
/// number.
void change_pin_velocity(Model& model, Index cloth, Index entry, const Vec3& velocity, double time);

/// From `time` (s) on nodes of a cloth, numbered within it from 0, move and turn with a body; `position` has where all
/// nodes are, m. Nodes that were attached to another body follow this one instead. std::invalid_argument: no such
/// cloth, node or body, a cloth that does not move, a body that is dynamic or deforms, a node that another pin holds.
void attach_nodes(Model& model, Index cloth, const std::vector<Index>& nodes, Index body,
                  const std::vector<Vec3>& position, double time);
/// Frees them. std::invalid_argument: as above, or a node that is not attached.
void detach_nodes(Model& model, Index cloth, const std::vector<Index>& nodes);
/// Nodes that move with a body, as rows of the node fields.
std::vector<Index> attached_nodes(const Model& model, Index body);

/// From `time` (s) on jet `jet` flows at `velocity`, m/s, from `center`, m, which stays where it is without a value. A
/// velocity of 0 closes it. std::invalid_argument: no such jet, no finite number; SetupError: a centre outside the
/// domain.
void change_jet(Model& model, Index jet, const Vec3& velocity, const std::optional<Vec3>& center, double time);

/// From now on the motor of joint `joint` holds this speed, rad/s. std::invalid_argument: no such joint, a joint
/// without motor, no finite number.
void change_motor(Model& model, Index joint, double speed);

/// std::invalid_argument: there is no such body.
const Body& body_numbered(const Model& model, Index body);
/// From `time` (s) on a commanded body moves at `velocity`, m/s, and turns at `spin`, rad/s.
/// std::invalid_argument: no such body, one that is not commanded, no finite number.
void change_body_velocity(Model& model, Index body, const Vec3& velocity, const Vec3& spin, double time);
/// From `time` (s) on a commanded body moves and turns steadily to a pose: its centre at `position`, m, and turned by
/// `orientation` since t = 0. It is there after `duration`, s, and stays. std::invalid_argument: as above, an
/// orientation of length 0, a duration that is not above 0.
void change_body_pose(Model& model, Index body, const Vec3& position, const Quaternion& orientation, double duration,
                      double time);
/// A force, N, and a torque about the centre, N m, act on a dynamic body until the next call.
/// std::invalid_argument: no such body, one that is not dynamic, no finite number.
void change_wrench(Model& model, Index body, const Vec3& force, const Vec3& torque);

/// The air moves at `velocity`, m/s, from now on, without gusts. std::invalid_argument: no finite number.
void change_wind(Model& model, const Vec3& velocity);

/// The numbers that bring a model of the same scene to where this one is; for checkpoints.
std::vector<double> to_numbers(const Model& model);
/// Takes them. std::invalid_argument: they are of another scene.
void take_numbers(Model& model, const std::vector<double>& numbers);

}  // namespace drench
