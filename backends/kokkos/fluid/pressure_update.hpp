#pragma once
// What a particle does at the end of a pressure iteration: its update and its share of the sums that judge the solve.
// Laws: docs/theory/liquid.md.

#include "fluid/pressure_solve.hpp"
#include "particles/source_ramp.hpp"

namespace drench::kokkos_backend {

/// What a step corrects of a density error.
struct Correction {
  Real factor, share;  // c and s of docs/theory/liquid.md, Eq. 24, 1

  /// t(o). Below rest density, o < 0, t(o) = o.
  KOKKOS_INLINE_FUNCTION Real operator()(Real over) const {
    constexpr Real most = Real(0.1);
    return smaller(over, share * larger(Real(0.5) * over, smaller(factor * over, most)));
  }
};

/// The norms of a particle, and the density error that it keeps: for the sum and the maximum.
struct RowDensityNorms {
  RowNorms norms;
  Real error = 0, error_max = 0;
};
struct DensitySums {
  IterationNorms norms;
  std::int64_t error = 0;
  double error_max = 0;
  KOKKOS_INLINE_FUNCTION DensitySums& operator+=(const DensitySums& o) {
    norms += o.norms;
    error += o.error;
    if (o.error_max > error_max) error_max = o.error_max;
    return *this;
  }
  void visit(OverRanks& all) {
    norms.visit(all);
    all.sum(error).maximum(error_max);
  }
};

/// An update of stage pressure: of a particle's κ and, where it touches a sheet, of its contact pressure λ.
struct DensityUpdate {
  using Sums = DensitySums;

  Entries<const std::uint8_t> origin;
  Entries<const Real> age, alpha, ratio, kappa, last;
  Entries<Real> next;
  // of liquid that can touch sheets
  Entries<const Real> contact_alpha, contact_compliance, contact, last_contact;
  Entries<Real> next_contact;
  Real dt, ramp;
  Correction correction;
  Real factor;
  bool touching;
  NormScale scale;

  KOKKOS_INLINE_FUNCTION DensitySums exact(const RowDensityNorms& n) const {
    return {scale.exact(n.norms), scale.error(n.error), n.error_max};
  }

  /// What counts of a particle that cloth has just given out, 1.
  KOKKOS_INLINE_FUNCTION Real weight(Index i) const {
    return alpha(i) == 0 ? Real(0) : source_ramp(origin(i), age(i), ramp);
  }
  KOKKOS_INLINE_FUNCTION RowNorms update_contact(Index i, Real beta, Real lambda_alpha, Real approach) const {
    next_contact(i) = 0;
    if (!(lambda_alpha > 0)) return {};  // λ_i = 0, and lean iterations leave contact(i) as it was
    const Real lambda = contact(i), gain = factor * lambda_alpha;
    const Real nearer = beta * dt * (approach - dt * contact_compliance(i) * lambda), before = last_contact(i);
    const Real p = updated(lambda, gain, nearer);
    next_contact(i) = p;
    return norms_of(nearer, lambda, gain, p, before, lambda_alpha);
  }
  /// α'_i, m²; 0: touches no sheet.
  KOKKOS_INLINE_FUNCTION Real touch(Index i) const { return touching ? contact_alpha(i) : Real(0); }
  /// r_i, 1, at a density rate, 1/s.
  KOKKOS_INLINE_FUNCTION Real residual(Index i, Real beta, Real lambda_alpha, Real rate) const {
    const Real over = lambda_alpha > 0 ? larger(ratio(i) - 1, Real(0)) : ratio(i) - 1;
    return beta * (correction(over) + dt * rate);
  }
  /// Of the density's rate of change and of how fast the liquid nears sheets, 1/s.
  KOKKOS_INLINE_FUNCTION RowDensityNorms operator()(const Index i, Real rate, Real approach) const {
    const Real beta = weight(i), lambda_alpha = touch(i), left = residual(i, beta, lambda_alpha, rate);
    const Real error = larger(beta * (ratio(i) - 1 + dt * rate), Real(0));
    const Real gain = factor * alpha(i), own = kappa(i), before = last(i), k = updated(own, gain, left);
    next(i) = k;
    RowNorms norms = norms_of(left, own, gain, k, before, alpha(i));
    if (touching) norms += update_contact(i, beta, lambda_alpha, approach);
    return {norms, error, error};
  }
};

/// An update of stage divergence.
struct DivergenceUpdate {
  using Sums = IterationNorms;

  Entries<const std::uint8_t> active;
  Entries<const Real> alpha, kappa, last;
  Entries<Real> next;
  Real factor;
  NormScale scale;

  KOKKOS_INLINE_FUNCTION IterationNorms exact(const RowNorms& n) const { return scale.exact(n); }
  KOKKOS_INLINE_FUNCTION RowNorms operator()(const Index i, Real rate, Real) const {
    const Real own = kappa(i), before = last(i);
    next(i) = 0;
    if (!active(i)) return {};
    const Real gain = factor * alpha(i), k = updated(own, gain, rate);
    next(i) = k;
    return norms_of(rate, own, gain, k, before, alpha(i));
  }
};

/// Mean of max(0, r_i) at the velocities that a solve begins with, 1. Waits for the device.
double mean_source(PressureSystem& system, const DensityUpdate& update);
/// The update at work.density_rate and work.approach_rate.
SumUnderWay<DensitySums> begin_full_update(const PressureSystem& system, const DensityUpdate& update, int slot);
SumUnderWay<IterationNorms> begin_full_update(const PressureSystem& system, const DivergenceUpdate& update, int slot);

}  // namespace drench::kokkos_backend
