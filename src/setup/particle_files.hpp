#pragma once
// Particle files by format.

#include <cmath>
#include <cstdint>
#include <string>

#include "setup/read_particles.hpp"

namespace drench {

/// Houdini's classic .bgeo (version 5), plain or gzipped: the points, `v` or `velocity`, `mass` and `id`. SetupError:
/// another version, Houdini's newer format, attributes of another type, an end before the last point.
ParticleFile read_bgeo_file(const std::string& path);

/// Arrays that NumPy saved by `savez` or `savez_compressed`, float32 or float64: `position`, of shape (N, 3), and if it
/// has them `velocity`, likewise, `mass`, of shape (N), and whole numbers `id`, likewise. SetupError: not such an
/// archive, no positions, another shape or type, lengths that differ.
ParticleFile read_npz_file(const std::string& path);

/// A particle's id; −1 for a number that is none.
inline std::int64_t id_of(double number) { return number >= 0 && number <= 0x1p53 ? std::llround(number) : -1; }

/// Throws SetupError: the file cannot be read, and why.
[[noreturn]] void unreadable_particles(const std::string& path, const std::string& why);

}  // namespace drench
