#pragma once
// Emitters whose nozzle moves, sprays or is a mesh: how much has come out by a time, and where and how fast a particle
// leaves. docs/theory/liquid.md, Where liquid comes from (Eqs. 29b to 29f, 29h).

#include <array>
#include <cstdint>
#include <vector>

#include "state/model.hpp"

namespace drench {

/// Liquid leaves faces faster than their flow over their area by so much: their points lie in no lattice, and a stream
/// that is denser than at rest anywhere would burst.
inline constexpr double faces_speed_factor = 1.05;

/// Steps of Roberts' sequence: 1/g and 1/g² of the root g of g³ = g + 1. Points that follow each other are far apart.
inline constexpr std::array<double, 2> roberts{0.7548776662466927, 0.5698402909980532};

/// Mouth::volumes of a jet that has all else.
Mouth::Volumes volumes_at_keys(const Jet& jet);
/// m³: the liquid that has come out of a moving mouth by `time`, s.
double volume_out(const Jet& jet, double time);
/// m³/s: its flow at a time, whether or not the emitter is open.
double flow_at(const Jet& jet, double time);
/// s: the time between two at which so much (m³) has come out.
double time_of_volume(const Jet& jet, double volume, double from, double to);

/// A place or a particle of a mouth.
struct Leaving {
  Vec3 position, velocity;  // m, m/s
};
/// The point of the mouth that particle k leaves from if it leaves at `time` (s), and the particle's velocity.
Leaving leaving_particle(const Jet& jet, std::int64_t k, double time);

/// Where the centre of a mouth that moves as a whole is at a time (s), m.
Vec3 center_of_mouth(const Jet& jet, double time);
/// All points of any jet's mouth at a time (s), m.
std::vector<Vec3> mouth_at(const Jet& jet, double time);
/// Times at which a mouth is looked at while it is open and until `end` (s): it alone if the mouth stands still.
std::vector<double> times_of_mouth(const Jet& jet, double end);

/// m/s: the fastest that liquid leaves between two times (s), with the motion of the mouth.
double fastest_leaving(const Jet& jet, double from, double to);
double fastest_leaving(const Jet& jet);  ///< at all times

}  // namespace drench
