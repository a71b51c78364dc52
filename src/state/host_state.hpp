#pragma once
// Everything that changes during a run.

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/types.hpp"
#include "state/fields.hpp"

namespace drench {

/// Where a particle comes from.
enum class Origin : std::uint8_t {
  block = 0,    ///< a block of the scene
  jet = 1,      ///< a jet
  cloth = 2,    ///< emitted by a cloth
  program = 3,  ///< added by a program
  mouth = 4,    ///< an emitter that moves or is a mesh
};

/// The ledger's accounts besides the masses of particles and nodes, in quanta, and the run's clock.
struct Accounts {
  Quanta drained = 0;                              ///< left the domain or entered a drain
  Quanta supplied = 0;                             ///< came from emitters and reservoirs (net)
  Quanta evaporated = 0;                           ///< went into the air
  Quanta solute_drained = 0, solute_supplied = 0;  ///< the same of the solute, in its own quanta
  Quanta solute_deposited = 0;                     ///< left behind where a particle vanished from around it
  std::int64_t step = 0;                           ///< steps so far
  double time = 0;                                 ///< s
};

/// What one step tells the next beside the state of liquid, cloth and bodies.
struct Carried {
  std::int64_t collapsing = 0;  ///< steps in a row at whose end the liquid collapsed (pipeline/failure.hpp)
  double uptake_rate = 0;       ///< quanta/s: at which cloth took up liquid in the last step
  double divergence_start = 0;  ///< 1: residual over tolerance that the last step's divergence solve began with
  double density_start = 0;     ///< 1: the same of its density solve
  double next_step = 0;         ///< s: what the last step's error allows (time.mode error); 0: nothing is known
};

/// Everything that changes during a run, as named arrays in double precision: the one exchange format between set-up,
/// both backends, output and tests, so that any stage runs alone from identical input on any backend. Masses are counts
/// of quanta; Simulation::quantum() is the size of one in kg. The arrays of a kind are equally long.
struct HostState : Accounts, Carried {
  // fluid_position, fluid_velocity, …, node_position, …: a vector for each field of the lists
#define DRENCH_ARRAY(owner, name, type, unit, needed) std::vector<type> owner##_##name;
  DRENCH_STATE_FIELDS(DRENCH_ARRAY)
#undef DRENCH_ARRAY

  std::int64_t next_id = 0;                 // fluid_id of the next new particle
  std::vector<std::int64_t> jet_particles;  // that each jet has let go so far

  /// Number of liquid particles.
  Index fluid_count() const { return static_cast<Index>(fluid_position.size()); }
  /// Number of cloth nodes.
  Index node_count() const { return static_cast<Index>(node_position.size()); }
  /// Number of samples of the cloths.
  Index sample_count() const { return static_cast<Index>(sample_volume.size()); }
  /// Number of solid bodies.
  Index body_count() const { return static_cast<Index>(body_position.size()); }
  /// Number of samples of solid bodies.
  Index boundary_count() const { return static_cast<Index>(boundary_position.size()); }
};

/// Calls visit(name, array) for every array of the state, e.g. ("fluid_position", s.fluid_position).
template <class State, class Visitor>
void visit_fields(State& s, Visitor&& visit) {
#define DRENCH_VISIT(owner, name, type, unit, needed) visit(std::string_view(#owner "_" #name), s.owner##_##name);
  DRENCH_STATE_FIELDS(DRENCH_VISIT)
#undef DRENCH_VISIT
}

/// The unit of a field of that name, "1" if it has none.
inline std::string_view unit_of_field(std::string_view field) {
#define DRENCH_UNIT(owner, name, type, unit, needed) \
  if (field == #owner "_" #name) return unit;
  DRENCH_STATE_FIELDS(DRENCH_UNIT)
#undef DRENCH_UNIT
  return "1";
}

}  // namespace drench
