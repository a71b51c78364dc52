#pragma once
// Rigid bodies of the oracle: poses, and how dynamic bodies answer to forces. Laws: src/stages/bodies.hpp.

#include "common.hpp"

namespace drench::reference {

/// m, m/s, rad/s.
struct Pose {
  Eigen::Vector3d position, velocity, spin;
  Eigen::Quaterniond orientation;

  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const { return velocity + spin.cross(x - position); }
};

RigidMotion motion_of(const Pose& pose);
Pose pose_from(const RigidMotion& motion);
Pose pose_of(const HostState& s, Index body);
void set_pose(HostState& s, Index body, const Pose& pose);
/// Of a body that is not dynamic, at a time (s).
Pose prescribed_pose(const Body& body, double time);
/// The steady turning that takes one orientation to another in `time`, s: rad/s.
Eigen::Vector3d angular_velocity(const Eigen::Quaterniond& first, const Eigen::Quaterniond& last, double time);
/// After dt of steady motion.
Pose advanced(const Pose& pose, double dt);
/// Gives the bodies the velocities that their contacts and hinges would leave them at the end of the step.
void hold(const ReferenceState& state, const StepInfo& info, std::vector<Pose>& poses);
/// Inertia in the world's axes, kg m².
Eigen::Matrix3d inertia(const Body& body, const Pose& pose);

/// Forces on the boundary samples, N → changes of the dynamic bodies' velocities in dt: v += Δt F/M, ω += Δt I⁻¹ T.
void accelerate_bodies(ReferenceState& state, const Vectors& sample_force, double dt);
/// Force times time, and about the centre: kg m/s, kg m²/s; (v, ω): m/s, rad/s.
using Six = Eigen::Matrix<double, 6, 1>;
/// A dynamic body gets an impulse: v += p/M, ω += I⁻¹ L. Samples do not follow yet (refresh_body_samples).
void push_body(ReferenceState& state, Index body, const Six& impulse);
/// boundary_velocity of the samples of dynamic bodies.
void refresh_body_samples(ReferenceState& state);

/// Forces of the pressures κ on the boundary samples, N.
Vectors body_pressure_forces(const ReferenceState& state, const std::vector<double>& kappa);
/// state.boundary_predicted: the velocities that these forces leave the boundary samples.
void respond_bodies(ReferenceState& state, const std::vector<double>& kappa, const StepInfo& info);
/// The dynamic bodies take what the pressures κ give them.
void accept_bodies(ReferenceState& state, const std::vector<double>& kappa, double dt);
/// What walls gave of the liquid's `change` of velocity (m/s), where they extrapolate the pressure, dynamic bodies
/// lose.
void push_bodies_back(ReferenceState& state, const Vectors& change);
/// The dynamic bodies' share of the Jacobi diagonal, added to α.
void add_body_rows(ReferenceState& state);

}  // namespace drench::reference
