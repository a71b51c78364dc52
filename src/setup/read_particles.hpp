#pragma once
// Particles from the files of other programs, and from frames of drench.

#include <cstdint>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

struct ParticleFile {
  std::vector<Vec3> position;      // in the file's unit
  std::vector<Vec3> velocity;      // that unit per s; empty: the file has none
  std::vector<double> mass;        // kg; empty: the file has none
  std::vector<std::int64_t> id{};  // empty: the file has none
};

/// Reads .ply (x y z, vx vy vz, mass, id), .vtu and .vtp (the points, point data `velocity` or `v`, `mass` and `id`),
/// and what particle_files.hpp says of .bgeo and .npz. SetupError: no such file, another ending, unreadable,
/// numbers that are not finite; without particles, unless `may_be_empty`.
ParticleFile read_particle_file(const std::string& path, bool may_be_empty = false);

}  // namespace drench
