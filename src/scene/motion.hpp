#pragma once
// Prescribed motion in a scene: what bodies, pins and emitters share.

#include <optional>
#include <string>
#include <vector>

#include "base/keyed.hpp"
#include "base/types.hpp"

namespace drench {

/// A rotation about a fixed axis, by the right-hand rule.
struct SpinScene {
  Vec3 axis{0, 1, 0};                // its length does not matter
  Keyed<double> degrees_per_second;  // °/s

  bool operator==(const SpinScene&) const = default;
};

/// A shape that moves from file to file, each with the same triangles.
struct SequenceScene {
  std::vector<std::string> files;  // the first at 0 s
  double fps = 24;                 // files a second

  bool operator==(const SequenceScene&) const = default;
};

/// Section `motion` of an emitter, from t = 0 without end.
struct NozzleMotionScene {
  Keyed<Vec3> velocity{};        // m/s
  Keyed<Vec3> offset{};          // m; added to where `velocity` brings it; 0 at t = 0
  SpinScene spin{};              // about `center`
  std::optional<Vec3> center{};  // m; moves with the nozzle; without it the nozzle's own centre

  bool operator==(const NozzleMotionScene&) const = default;
};

/// Does the emitter move?
inline bool moves(const NozzleMotionScene& motion) {
  return !motion.velocity.is_zero() || !motion.offset.is_zero() || !motion.spin.degrees_per_second.is_zero();
}

}  // namespace drench
