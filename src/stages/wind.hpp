#pragma once
// Stage wind: the drag of moving air on cloth and, where `wind.liquid_drag` is above 0, on free liquid.
//
// Law:    docs/dev/add_a_force.md, section 1: the air (Eq. 1), cloth (2 to 5), liquid (6 to 8).
// Reads:  time (s), node_position (m), node_velocity (m/s), node_liquid, fluid_mass (quanta), fluid_position (m), lists
//         of the liquid; the scene's `wind`.
// Writes: node_velocity, fluid_velocity (m/s), node_pin_force (N).
// Errors: none. The drag is implicit in the relative velocity: no Δt overshoots the air's.

#include <algorithm>
#include <cmath>

#include "scene/scene.hpp"

namespace drench {

/// Eq. 1: the velocity of undisturbed air at a time (s), m/s.
inline Vec3 air_velocity(const WindScene& wind, double time) {
  Vec3 u = wind.velocity.at(time);
  const auto& gusts = wind.gusts;
  if (gusts.empty()) return u;
  const auto after = std::find_if(gusts.begin(), gusts.end(), [&](const GustScene& gust) { return gust.time > time; });
  const GustScene &next = after == gusts.end() ? gusts.back() : *after,
                  &last = after == gusts.begin() ? next : after[-1];
  const double part = next.time > last.time ? (time - last.time) / (next.time - last.time) : 0;
  for (std::size_t a = 0; a < 3; ++a) u[a] += (1 - part) * last.velocity[a] + part * next.velocity[a];
  return u;
}

/// The fastest that the air ever is, m/s; with keys and gusts, no more than this.
inline double fastest_air(const WindScene& wind) {
  const auto speed = [](const Vec3& u) { return std::hypot(u[0], u[1], u[2]); };
  if (wind.velocity.has_keys()) {
    double gust = 0;
    for (const GustScene& g : wind.gusts) gust = std::max(gust, speed(g.velocity));
    return wind.velocity.largest() + gust;
  }
  double fastest = wind.gusts.empty() ? wind.velocity.largest() : 0;
  for (const GustScene& gust : wind.gusts) fastest = std::max(fastest, speed(air_velocity(wind, gust.time)));
  return fastest;
}

}  // namespace drench
