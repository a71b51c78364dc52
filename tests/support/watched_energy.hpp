#pragma once
// The energy of a state, and what comes in and goes out within a step, as far as it can be seen from outside.

#include "watch.hpp"

namespace drench::test {

/// J, within one step.
struct EnergyInput {
  double pins = 0;            ///< work of the pins that move
  double jets = 0;            ///< energy of new particles out of emitters
  double jet_motion = 0;      ///< the part of it that is motion
  double drained = 0;         ///< energy of particles that left the domain, as they were before
  double exchanged = 0;       ///< at most: liquid that goes into cloth, out of it or along it is lifted by its reach
  std::int64_t absorbed = 0;  ///< particles that vanished within the domain
};

/// Kinetic energy of particles and wet nodes, J.
double motion_energy(const Model& m, const HostState& s);
/// How far energy may lie from what symplectic Euler keeps in a field, E − ½ Δt Σ m Σ_a ω_a² (x_a − c_a) v_a; J.
double sway(const Model& m, const HostState& s, double dt);
/// Of springs, hinges and strain limits, J; 0 of cloth that does not move.
double elastic_energy(const Model& m, const HostState& s);
/// A step of `dt` s takes back what the density is off: at most η, by a solve's tolerance or by the part that it
/// corrects of a lattice that starts compressed. ½ M (η h / Δt)², J.
double correction(const Model& m, const HostState& s, double dt);
/// Of particles and wet nodes, N.
double weight(const Model& m, const HostState& s);
EnergyInput energy_input(const Model& m, const HostState& before, const HostState& now, double dt);

}  // namespace drench::test
