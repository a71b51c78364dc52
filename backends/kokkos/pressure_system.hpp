#pragma once
// What the divergence and the density solve share: pressure accelerations from κ, coupled to the cloth, and the rate of
// compression that they leave. Laws: src/stages/divergence.hpp.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Does the density solve have contact with sheets (src/stages/pressure.hpp)?
inline bool has_contact(const Device& d) { return d.samples.count > 0 && !d.model.scene.through_cloth; }

/// work.predicted = v_i + Δt a_i(κ, λ) and its thrust, with κ in work.place (PressureIteration keeps it there); `touching`:
/// with the λ of work.contact.
void predict_liquid(Device& d, Real dt, bool touching);
/// Particles with α = 0 carry no pressure: their κ of the density solve becomes 0. The others' thrust goes to work.predicted.
void clear_inactive(Device& d);
/// nodes.force = f_n, N, of the thrusts in work.predicted.
void cloth_forces(Device& d);
/// Nodes that answer with their inertia alone: nodes.acceleration = a_n, samples.predicted = v_b + Δt a_b.
void free_cloth_response(Device& d, Real dt);
/// work.rate = R_i of the predicted velocities − Δt C_i κ_i, 1/s; `touching`: contact.rate = R'_i too.
void compression_rate(Device& d, const Array<Real>& kappa, Real dt, bool touching);
/// v_i := predicted.
void accept_liquid(Device& d);
/// v_n += Δt a_n, pin_force −= f_n on pinned nodes.
void accept_free_cloth(Device& d, Real dt);

/// What both solves iterate with: projected Jacobi with Nesterov's momentum and restarts (src/stages/divergence.hpp).
class PressureIteration {
 public:
  /// `touching`: λ of work.contact is iterated with κ.
  PressureIteration(Device& d, const Array<Real>& kappa, bool touching)
      : device_(d), kappa_(kappa), touching_(touching), relaxation_(Real(d.model.relaxation)) {}
  /// Begins at κ and at λ = 0. Not in the constructor: nvcc wants kernels in functions that have an address.
  void start();
  /// ω of the next update.
  Real relaxation() const { return relaxation_; }
  /// κ := the next point y, from work.kappa_next = κ⁺ and kappa_last = the κ⁺ before, λ likewise. `residual`:
  /// error + excess of the κ that is left; `against_momentum`: the scalar product that decides about a restart.
  void advance(double residual, double against_momentum);
  /// Does the solve go on after this iteration whatever its residual is? Then the host need not wait for it: the first
  /// advance does not depend on it. `saw_first` hands it in before the second.
  static bool goes_on_unseen(int iteration, const FluidSolverScene& solver) {
    return iteration == 1 && solver.min_iterations > 1;
  }
  void advance_first() { move_on(); }
  void saw_first(double residual) { smallest_ = last_ = residual; }
  /// The next of Nesterov's weights, and κ and λ with it: what all advances end with. (Public for nvcc's sake.)
  void move_on();

 private:
  static constexpr double most_growth = 4;
  Device& device_;
  Array<Real> kappa_;
  bool touching_;
  Real relaxation_;
  double weight_ = 1, smallest_ = 1e300, last_ = 1e300;
};

/// max(0, κ⁺): one Jacobi update, `gain` = ω α/Δt^k.
KOKKOS_INLINE_FUNCTION Real updated(Real kappa, Real gain, Real residual) {
  const Real k = kappa + gain * residual;
  return k > 0 ? k : Real(0);
}

/// How much too high a particle's pressure is, in units of the residual: −residual where it is negative, at most what
/// lowering κ to 0 in one update of gain `gain` = ω α/Δt^k can take back. 0 where the residual is positive.
KOKKOS_INLINE_FUNCTION double excess_pressure(double residual, double kappa, double gain) {
  if (residual >= 0 || kappa <= 0 || gain <= 0) return 0;
  const double most = kappa / gain;
  return -residual < most ? -residual : most;
}

}  // namespace drench::kokkos_backend
