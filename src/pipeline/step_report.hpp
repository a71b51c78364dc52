#pragma once
// The numbers that a step tells of itself: for the pipeline, stats.csv, the run log, and programs that use the library.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// Particles that something happened to: how many, and the lowest of their ids.
struct SomeParticles {
  std::int64_t count = 0;                ///< how many
  std::array<std::int64_t, 8> lowest{};  ///< ids, rising; only the first min(count, 8) entries are any
  /// "3 17", or the first eight and "…".
  std::string names() const;
};

/// A porous cloth in numbers (stages/fabric.hpp). What came and went counts from the start; its front is where its
/// triangles' normals point.
struct FabricNumbers {
  Index cloth = 0;                         ///< its number in the scene, from 0
  Quanta liquid = 0;                       ///< quanta: in it
  Quanta taken_front = 0, taken_back = 0;  ///< quanta: from liquid on either face
  Quanta given_front = 0, given_back = 0;  ///< quanta: to liquid on either face
  double wet_area = 0;                     ///< m², at rest
  double wet_warp = 0, wet_weft = 0;       ///< m, at rest: extent of what is wet
  /// Is the front the face that took more?
  bool wetted_at_front() const { return taken_front >= taken_back; }
  /// quanta: struck through, to the face across from the one that took more
  Quanta through() const { return wetted_at_front() ? given_back : given_front; }
  /// quanta: given back by the face that took more
  Quanta returned() const { return wetted_at_front() ? given_front : given_back; }
};

/// Where a body is and how it moves.
struct BodyMotion {
  Vec3 position{0, 0, 0};                             ///< m: its centre
  std::array<double, 4> orientation{1, 0, 0, 0};      ///< quaternion w x y z: how it is turned since the start
  Vec3 velocity{0, 0, 0}, angular_velocity{0, 0, 0};  ///< m/s, rad/s
};

/// What acts on a body: forces, N, and torques about its centre, N m.
struct BodyLoad {
  Vec3 liquid_force{0, 0, 0}, liquid_torque{0, 0, 0};      ///< pressure and viscosity of the liquid
  Vec3 cloth_force{0, 0, 0}, cloth_torque{0, 0, 0};        ///< contact, friction and wet adhesion of cloth
  Vec3 attached_force{0, 0, 0}, attached_torque{0, 0, 0};  ///< of nodes that are attached to the body
  Vec3 contact_force{0, 0, 0},
      contact_torque{0, 0, 0};  ///< contact with other bodies, dynamic ones or of a dynamic one
};

/// What a step has done, in numbers. Each stage fills in its own part, and the pipeline `step`, `time` and `dt`. Where
/// a stage does not run its part stays as it is here. Masses are counts of quanta; Simulation::quantum() is the size of
/// one in kg.
struct StepReport {
  std::int64_t step = 0;  ///< number of the step, from 1
  double time = 0;        ///< s, at the step's end
  double dt = 0;          ///< s, the step's length
  double dt_wanted = 0;   ///< s: what the scene allows; a step may be shorter, to end where it is asked to

  int divergence_iterations = 0;      ///< of the divergence solve
  double divergence_error = 0;        ///< 1: mean of max(0, Dδ/Dt) Δt that it leaves
  bool divergence_converged = true;   ///< false: it ended at its cap
  int density_iterations = 0;         ///< of the density solve
  double density_error = 0;           ///< 1: mean of max(0, δ − 1) that it leaves
  double density_error_max = 0;       ///< 1: the same of the worst particle
  bool density_converged = true;      ///< false: it ended at its cap
  double density_found = 0;           ///< 1: mean of max(0, δ − 1) at the step's end (time.mode error)
  int rejected = 0;                   ///< longer steps that were tried before this one (time.mode error)
  double divergence_start = 0;        ///< 1: residual over tolerance that its solve began with, where liquid is alone
  double density_start = 0;           ///< 1: the same of the density solve (docs/theory/liquid.md, Eq. 20a)
  int viscosity_stages = 0;           ///< of the viscous solve (docs/theory/viscosity.md); 0 without viscosity
  int micropolar_stages = 0;          ///< of the solve for spins (docs/theory/micropolar.md)
  int cloth_iterations = 0;           ///< of the cloth's solve, also within the density solve
  double cloth_residual = 0;          ///< 1: unbalanced forces over their goal (stages/cloth.hpp); converged at ≤ 1
  bool cloth_converged = true;        ///< false: stage cloth's solve ended at its cap
  std::int64_t cloth_contacts = 0;    ///< pairs of the cloth with itself in contact
  std::int64_t cloth_zone_nodes = 0;  ///< cloth nodes in impact zones, the failsafe of self_collision
  int diffusion_substeps = 0;         ///< of the diffusion in the cloth
  std::int64_t collisions = 0;        ///< particles stopped at a cloth triangle
  std::int64_t clamped = 0;           ///< particles put back by a solid's failsafe

  Quanta mass_fluid = 0;        ///< quanta: in particles
  Quanta mass_cloth = 0;        ///< quanta: in cloth
  Quanta mass_drained = 0;      ///< quanta: left the domain or entered a drain so far
  Quanta mass_supplied = 0;     ///< quanta: from emitters and reservoirs so far
  Quanta mass_evaporated = 0;   ///< quanta: gone into the air so far
  Quanta solute_fluid = 0;      ///< quanta of solute, Simulation::solute_quantum() in kg: in particles
  Quanta solute_cloth = 0;      ///< the same: on cloth
  Quanta solute_drained = 0;    ///< the same: left with it so far
  Quanta solute_supplied = 0;   ///< the same: from emitters and reservoirs so far
  Quanta solute_deposited = 0;  ///< the same: left behind by particles that vanished so far
  double mass_float = 0;        ///< kg: compensated sum of the floating-point masses of particles and nodes
  double saturation_max = 0;    ///< 1: of the wettest node
  double saturation_error = 0;  ///< 1: estimate of what the step's length costs the cloth's mean saturation (Pipeline)
  double kinetic_energy = 0;    ///< J: liquid particles and wet cloth nodes
  std::int64_t particles = 0;   ///< liquid particles
  std::int64_t nonfinite = 0;   ///< particles, nodes and bodies with a NaN or infinity; a step that returns has none

  double nearest_variance = 0;  ///< 1: how clumped the liquid is (stages/measures.hpp)
  double close_share = 0;       ///< 1: share of particles with another one close by
  double wet_isotropy = 0;      ///< 1: how round the wet patch is

  std::vector<FabricNumbers> fabrics{};  ///< of each porous cloth (output.fabric)

  double imbalance = 1;   ///< 1: particles of the fullest rank over the mean of all ranks
  std::int64_t cuts = 0;  ///< how often space has been cut anew since the start of the run

  // what a run is watched by (pipeline/failure.hpp)
  double fluid_speed = 0;              ///< m/s: of the fastest particle
  double cloth_speed = 0;              ///< m/s: of the fastest node
  double cloth_stretch = 0;            ///< 1: the largest length of an edge over that at rest
  std::int64_t tunnelled = 0;          ///< particles that went through a cloth that is whole
  std::int64_t lowest_tunnelled = -1;  ///< the lowest of their ids, −1: none
  SomeParticles escaped{};             ///< left the domain in this step, if suspiciously many or fast
  double escaped_speed = 0;            ///< m/s: of the fastest particle that left the domain

  /// quanta: particles + cloth + drained + evaporated − supplied, the same after every step
  Quanta mass_total() const { return mass_fluid + mass_cloth + mass_drained + mass_evaporated - mass_supplied; }
  /// quanta of solute: particles + cloth + drained + deposited − supplied, the same after every step
  Quanta solute_total() const {
    return solute_fluid + solute_cloth + solute_drained + solute_deposited - solute_supplied;
  }
  /// Takes up the residual of the solve that the density solve has gone on with (stages/pressure.hpp). That one begins
  /// where stage cloth's ended, as if it had converged: what was left there is left.
  void note_cloth_residual(double coupled) {
    cloth_residual = cloth_converged ? coupled : std::max(cloth_residual, coupled);
  }
};

}  // namespace drench
