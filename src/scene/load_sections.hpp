#pragma once
// The readers of a scene's sections: what each file of the loader has for the others.

#include "scene/reader.hpp"
#include "scene/scene.hpp"

namespace drench {

inline constexpr const char* coordinate_range = "[-10000, 10000]";  // m: far beyond any scene, near enough for float
inline constexpr const char* speed_range = "[-1000, 1000]";         // m/s: below the speed of sound in water

/// A vector that is to give a direction: one of 1e-9 is not told from none.
inline void check_not_zero(Section& s, const char* key, const Vec3& v) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  s.check(square >= 1e-18, key, "has length 0; allowed: a vector that points somewhere");
}

void read_box(Section& s, Box& box);
void read_spin(Section& s, SpinScene& spin);
void read_cloth(Section& s, ClothScene& cloth);  // load_cloth.cpp
void read_cloth_solver(Section& s, ClothSolverScene& solver);
void read_body(Section& s, BodyScene& body);  // load_bodies.cpp

}  // namespace drench
