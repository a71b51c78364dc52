#pragma once
// Which fields a model needs (the last column of fields.hpp), and how the liquid's change in number.

#include <string_view>

#include "state/fields.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

inline bool needs_field([[maybe_unused]] const Model& m, std::string_view field) {
#define DRENCH_NEEDED(owner, name, type, unit, needed) \
  if (field == #owner "_" #name) return needed;
  DRENCH_STATE_FIELDS(DRENCH_NEEDED)
#undef DRENCH_NEEDED
  return false;
}

/// Gives the liquid `count` particles with all fields that the model needs; new entries are 0.
inline void resize_liquid(HostState& s, const Model& m, std::size_t count) {
  visit_fields(s, [&](std::string_view field, auto& values) {
    if (field.starts_with("fluid_")) values.resize(needs_field(m, field) ? count : 0);
  });
}

/// What the maker of a particle gives; everything else begins at 0.
struct NewParticle {
  Vec3 position, velocity;  // m, m/s
  Quanta mass = 0;
  Origin origin = Origin::block;
  Quanta solute = 0;
};

/// Appends a particle with the next id.
inline void append_particle(HostState& s, const Model& m, const NewParticle& particle) {
  const std::size_t last = s.fluid_position.size();
  resize_liquid(s, m, last + 1);
  s.fluid_position[last] = particle.position;
  s.fluid_velocity[last] = particle.velocity;
  s.fluid_mass[last] = particle.mass;
  s.fluid_id[last] = s.next_id++;
  s.fluid_origin[last] = static_cast<std::uint8_t>(particle.origin);
  if (m.has_solute()) s.fluid_solute[last] = particle.solute;
}

}  // namespace drench
