#pragma once
// Particles in the formats of other tools. Each takes a frame of the liquid as grids.hpp makes it and keeps all its
// fields.

#include <vtkUnstructuredGrid.h>

#include <filesystem>

namespace drench {

/// Classic BGEO, version 5: big-endian, as Houdini, partio and splashsurf read it. Names are Houdini's: v for velocity
/// (m/s), pscale for radius (m); others stay. Reals are 4 bytes, integers too. Throws std::runtime_error: the disk
/// refuses, or an integer needs more.
void write_bgeo(const std::filesystem::path& path, vtkUnstructuredGrid* particles);

/// Binary little-endian PLY with one vertex a particle: x y z, vx vy vz for velocity, and each other field under its
/// name; a vector's components end in _x _y _z. The time (s) stands in a comment. Throws as write_bgeo().
void write_ply(const std::filesystem::path& path, vtkUnstructuredGrid* particles, double time);

}  // namespace drench
