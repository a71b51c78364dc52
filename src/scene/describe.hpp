#pragma once
// The descriptions of a scene's sections (scene/section.hpp). A key of a scene is a line in one of these functions and
// a member of the struct.

#include <fmt/format.h>

#include <array>
#include <limits>

#include "scene/scene.hpp"
#include "scene/section.hpp"

namespace drench {

inline constexpr const char* coordinate_range = "[-10000, 10000]";  // m: far beyond any scene, near enough for float
inline constexpr const char* speed_range = "[-1000, 1000]";         // m/s: below the speed of sound in water
inline constexpr const char* turn_range = "[-1745, 1745]";          // rad/s: 1e5 degrees/s; of what a program sets
inline constexpr const char* air_speed_range = "[-200, 200]";       // m/s: beyond any storm, below the speed of sound
inline constexpr const char* direction_range = "[-1e6, 1e6]";       // 1
inline constexpr const char* concentration_range = "[0, 1]";        // kg/kg

/// Of a wall or a cloth: slip lengths with a word of their own.
inline constexpr std::array<Word<double>, 2> slip_words{
    {{"no", 0.0}, {"free", std::numeric_limits<double>::infinity()}}};
inline constexpr const char* slip_range = "[0, 10000]";  // m

/// A vector that is to give a direction: one of 1e-9 is not told from none.
inline void check_not_zero(Section& s, const char* key, const Vec3& v) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  s.check(square >= 1e-18, key, "has length 0; allowed: a vector that points somewhere");
}

/// The same of a vector that may be 0 at times.
inline void check_not_zero(Section& s, const char* key, const Keyed<Vec3>& v) {
  if (!v.has_keys()) return check_not_zero(s, key, v.plain());
  s.check(v.largest() >= 1e-9, key, "has length 0 in all keys; allowed: one at least that points somewhere");
}

/// How far something is from where it starts at time `start`, s.
inline void check_offset(Section& s, const Keyed<Vec3>& offset, double start) {
  s.check(offset.interpolation() != Interpolation::step, "offset.interpolation",
          "would move it at once; allowed: linear, smooth");
  s.check(offset.at(start) == Vec3{0, 0, 0}, "offset",
          fmt::format("is not 0 at {} s, where it starts; allowed: [0, 0, 0] there", start));
}

/// The times between which something lasts, keys `start` and `end`.
inline void check_end_after_start(Section& s, const char* what, double start, double end) {
  s.check(start < end, s.has("end") ? "end" : "start",
          fmt::format("{} ends at {} s and starts at {} s; allowed: an end after the start", what, end, start));
}

// describe_scene.cpp
void describe(Section& s, Scene& scene);
void describe(Section& s, TimeScene& time);
void describe(Section& s, FieldScene& field);
void describe(Section& s, AirScene& air);
void describe(Section& s, OutputScene& output);
void describe(Section& s, ProcessScene& processes);
void describe(Section& s, Box& box);
void describe(Section& s, SpinScene& spin);

/// Keys `unit` and `up` of a mesh file; saved where there is one.
void describe_coordinates(Section& s, LengthUnit& unit, UpAxis& up, bool saved);
/// Keys `sequence` and `fps`; saved where there is one. Only a moving mesh may be a point cache.
enum class SequenceOf { moving_mesh, surfaces, particles };
void describe_sequence(Section& s, SequenceScene& sequence, const char* meaning,
                       SequenceOf of = SequenceOf::moving_mesh);
/// The mesh of one that moves: `file`, by which `sequence` and `fps` follow.
void describe_moving_file(Section& s, std::string& file, SequenceScene& sequence, const char* file_meaning,
                          const char* meaning);

// describe_fluid.cpp
void describe(Section& s, FluidScene& fluid);
void describe(Section& s, MicropolarScene& micropolar);
void describe(Section& s, FluidSolverScene& solver);
void describe(Section& s, BlockScene& block);
void describe(Section& s, JetScene& jet);
void describe(Section& s, MeshJetScene& jet);
void describe(Section& s, DrainScene& drain);
void describe(Section& s, RainScene& rain);
void describe(Section& s, SprayScene& spray);

// describe_cloth.cpp
void describe(Section& s, ClothSolverScene& solver);
void describe(Section& s, ClothScene& cloth);
void describe(Section& s, GridScene& grid);
void describe(Section& s, PinScene& pin);
void describe(Section& s, SewScene& sew);
void describe(Section& s, RegionScene& region);
void describe(Section& s, MembraneScene& membrane);
void describe(Section& s, PlateScene& plate);
void describe(Section& s, SaturationScene& saturation);
void describe(Section& s, StainScene& stain);
void describe(Section& s, ProbeScene& probe);

/// `s.word("fabric", …)`: what it gives is in the scene's tree by now (scene/fabrics.hpp), and a resolved scene has the
/// values.
void describe_fabric(Section& s, const char* meaning);
/// What regions need of their cloth.
void check_regions(Section& s, const ClothScene& cloth);
/// Rates along warp and weft, and powers of the saturation, in section `porous`.
void check_rates(Section& s, const MaterialScene& fabric);
/// Refuses two statements of the quadratic drag, and one without permeability.
void check_drag(Section& s, const MaterialScene& fabric);

// describe_bodies.cpp
void describe(Section& s, BodyScene& body);
void describe(Section& s, MotorScene& motor);
void describe(Section& s, JointScene& joint);

}  // namespace drench
