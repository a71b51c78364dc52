#pragma once
// Prescribed motion in a scene: what bodies, pins and emitters share.

#include <filesystem>
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

/// ".pc2" or ".mdd" if a name ends so, in any case; else "".
inline std::string point_cache_ending(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending == ".pc2" || ending == ".mdd" ? ending : "";
}

/// A shape that moves from file to file, each with the same triangles, or as a point cache moves a mesh file.
struct SequenceScene {
  std::vector<std::string> files;  // the first at 0 s
  double fps = 24;                 // files per second; of a .pc2 file, frames

  /// Are its files point caches? There is one then.
  bool is_cache() const { return !files.empty() && !point_cache_ending(files.front()).empty(); }
  /// Are the times of its samples in its file?
  bool has_times() const { return !files.empty() && point_cache_ending(files.front()) == ".mdd"; }
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
