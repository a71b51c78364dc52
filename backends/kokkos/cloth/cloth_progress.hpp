#pragma once
// Chebyshev's weights of the cloth's Jacobi iterations, and when they start again. Law: docs/theory/cloth.md,
// section 8.

#include "core/reduce.hpp"

namespace drench::kokkos_backend {

// Iterations before Chebyshev's weights begin; the same after the target has moved, where there are no solids; from
// check to check.
inline constexpr int plain_iterations = 10, plain_iterations_later = 2, check_interval = 10;
inline constexpr int patient = 9;  // checks after which xpbd's residual must have fallen
// Checks in which the residual has to fall to this part of what it was, else the iterations stall (docs/dev/cloth.md).
inline constexpr int stall_checks = 40;
inline constexpr double stall_part = 0.95;
// Every so many checks, from the second time on, the fall of the residual is extrapolated to its goal.
inline constexpr int forecast_checks = 10;
inline constexpr double unlimited = 1e300;
// So many iterations on a GPU take as long as Newton's method on its host, per node (docs/dev/cloth.md).
inline constexpr double iterations_per_node = 0.15;

/// The residual in units of its goal, of the nodes' shares (ClothSystem::imbalance).
KOKKOS_INLINE_FUNCTION double over_goal(const TwoSums& sums) {
  return sums.first == 0 ? 0 : sums.first / sums.second;  // what is not finite stays so
}

/// Does a residual that has fallen from `before` to `now` since the last forecast, if it goes on like that, take more
/// than `most` iterations down to its goal?
KOKKOS_FUNCTION DRENCH_SELDOM inline bool takes_more(double most, double before, double now) {
  if (!(now > 1)) return false;
  const double fall = Kokkos::log(before / now);
  return !(forecast_checks * check_interval * Kokkos::log(now) <= most * larger(0.0, fall));
}

/// Chebyshev's weights (Wang 2015) and what the checks have found.
struct ClothProgress {
  double rho = 0, omega = 1, smallest = 1e300, residual = 1e300, marked = 1e300;
  int since_restart = 0, iterations = 0, plain = plain_iterations, since_mark = 0;
  double last_progress = 1e300;  // the residual that counts for a stall
  int since_progress = 0;        // checks
  bool ends_at_stall = false;    // Newton's method follows, or has been tried
  double worth = unlimited;      // iterations that a forecast may ask for: more take longer than Newton's method
  double forecast_from = 1e300;  // the residual at the last forecast
  int checks = 0;
  bool is_hopeless = false;
  bool newton_failed = false;  // a call of Newton's method in this solve, on a GPU
  int patience = 0;            // checks after which the residual must be below the marked one; 0: it may be anything

  /// ω of the next iteration.
  KOKKOS_INLINE_FUNCTION Real next_weight() {
    if (since_restart == plain) omega = 2 / (2 - rho * rho);
    if (since_restart > plain) omega = 4 / (4 - rho * rho * omega);
    ++since_restart;
    ++iterations;
    return static_cast<Real>(omega);
  }
  /// The target has moved: the weights start again.
  KOKKOS_INLINE_FUNCTION void move_on(bool solids) {
    restart(solids ? plain_iterations : plain_iterations_later);
    if (patience > 0 && residual > 1) patience = 1;
    smallest = marked = last_progress = forecast_from = 1e300;
    since_progress = checks = 0;
    is_hopeless = false;
  }
  KOKKOS_INLINE_FUNCTION bool stalls() const {
    return ends_at_stall && (since_progress >= stall_checks || is_hopeless);
  }
  /// If the residual has not fallen in time, or has grown tenfold over the smallest so far, ρ is lowered and the
  /// weights start again.
  KOKKOS_INLINE_FUNCTION void judge(double found) {
    residual = found;
    const bool due = ++since_mark >= patience || marked == 1e300;
    if (patience > 0 && due && found > marked) slow_down(plain_iterations_later);
    if (found > 10 * smallest) slow_down(plain_iterations);
    smallest = smaller(smallest, found);
    ++since_progress;
    if (found < stall_part * last_progress) {
      last_progress = found;
      since_progress = 0;
    }
    if (++checks % forecast_checks == 0) {
      is_hopeless = worth < unlimited && checks > forecast_checks && takes_more(worth, forecast_from, found);
      forecast_from = found;
    }
    if (!due) return;
    marked = found;
    since_mark = 0;
  }
  KOKKOS_INLINE_FUNCTION void slow_down(int before_weights) {
    rho = larger(0.0, 1 - 2 * (1 - rho));
    restart(before_weights);
  }
  KOKKOS_INLINE_FUNCTION void restart(int before_weights) {
    omega = 1;
    since_restart = 0;
    plain = before_weights;
  }
};

}  // namespace drench::kokkos_backend
