#pragma once
// Solid bodies that move: their poses and where the solids are; how dynamic ones answer to pressure and viscosity.
// Laws: src/stages/bodies.hpp. Every function does nothing if the scene has no such body.

#include "device.hpp"
#include "primitives/reduce.hpp"

namespace drench::kokkos_backend {

void upload_bodies(Device& d, const HostState& s);
void download_bodies(const Device& d, HostState& s);

/// d.solids: the moving ones where they will be at the end of the step.
void place_solids(Device& d, double dt);

/// The largest speed of a moving body's surface, m/s; of a dynamic one with `fall` (m/s) added.
double fastest_body(Device& d, double fall);

/// boundary_fluid: the liquid near the samples of dynamic bodies.
void list_body_neighbors(Device& d);

/// boundary.velocity of the samples of dynamic bodies, from the bodies' velocities.
void refresh_body_samples(Device& d);

/// The dynamic bodies' share of the Jacobi diagonal, added to work.alpha.
void add_body_rows(Device& d);

/// bodies.force: the liquid's viscous pull at the velocities as they are.
void viscous_body_forces(Device& d);
/// Adds what these forces do to the bodies at most, 1/s (bodies.hpp, law 4).
void find_viscous_body_bound(Device& d, MaximaUnderWay& maxima);
/// The bodies' momenta change by keep · the last change + weight (s) · (bodies.force and, if asked for, gravity).
void body_stage(Device& d, double keep, double weight, bool gravity);

/// The velocities that the pressures κ leave the samples of bodies: bodies.predicted = v_b + Δt (a + α × r).
void body_response(Device& d, const Array<Real>& kappa, double dt);

/// The bodies take the velocities of the last body_response.
void accept_bodies(Device& d, double dt);

/// The velocities of boundary samples that a pressure solve sees.
inline const Array<Real3>& seen_boundary_velocity(const Device& d) {
  return d.bodies.samples > 0 ? d.bodies.predicted : d.boundary.velocity;
}

}  // namespace drench::kokkos_backend
