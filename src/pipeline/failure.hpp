#pragma once
// When a run cannot go on, and what no healthy run comes to.

#include <stdexcept>
#include <string>

#include "pipeline/backend.hpp"

namespace drench {

enum class FailureKind {
  not_finite,     // a NaN or an infinity
  time_step,      // no Δt
  sub_steps,      // more of them in a step than a run could wait for
  mass,           // the ledger's total has changed
  fluid_speed,    // a particle beyond Limits
  cloth_speed,    // a node beyond Limits
  cloth_stretch,  // an edge beyond Limits
  density,        // the liquid collapses
};

/// A run that cannot go on.
struct RunFailure : std::runtime_error {
  RunFailure(FailureKind kind, Stage stage, const StepInfo& info, const StepReport& report, const std::string& what,
             double limit = 0);
  FailureKind kind;
  Stage stage;  // that noticed
  StepInfo info;
  StepReport report;  // of the stages up to this one
  double limit;       // what was exceeded, in the kind's unit
};

/// Bounds that a run passes only when it diverges. They are wide on purpose: a false alarm ends a good run, and a
/// divergence grows by orders of magnitude within a few steps.
///   Liquid: |v| ≤ 10 (u + d/Δt), u = the fastest that the scene prescribes + min(|g| t, √(2 |g| D)) + max Ω · D
///     + √(2 s/(ρ0 d)), D the domain's diagonal: nothing in it falls or is drawn farther; s the largest of surface tension and
///     adhesion, whose root is the speed of a film of one particle that retracts (Culick 1960). Splashes are a few times as
///     fast as what makes them, not ten times. d/Δt, with Δt = time.step, is what a solver makes of particles that overlap.
///   Cloth: |v| ≤ 10 (u + |g| t + ℓ/Δt), ℓ the longest edge: cloth is not removed at the domain's border and falls on.
///   Stretch: an edge of stiffness k and length L holds ½ k s² at an elongation of s. All liquid and cloth together (M,
///     kg, what jets have brought and dynamic bodies included) have no more than ½ M (u + |g| t)², and what pins pull and
///     bodies push goes no farther than they do: length/L ≤ 10 (1 + ((u + |g| t) √(M/k) + 2 u t)/L). Reservoirs supply
///     without end, so with them there is no bound.
/// t is the run's time, so that the bounds are narrow where a run that starts badly needs them.
struct Limits {
  double prescribed = 0;             // m/s: the fastest that the scene prescribes: a source, a pin, a point of a body
  double scale = 0;                  // m/s: u without what gravity adds
  double gravity = 0;                // m/s²
  double longest_fall = 0;           // m/s: √(2 |g| D)
  double particle = 0, edge = 0;     // m/s: d/Δt, ℓ/Δt
  double mass = 0;                   // kg, of all that there was at the start
  double supply = 0;                 // kg/s, of all jets
  double softest = 0, shortest = 0;  // √(m/N)/m: the largest 1/(L √k); 1/m: the largest 1/L

  Limits() = default;
  /// `liquid`, kg: all of it, in particles and in the cloth.
  Limits(const Model& model, double liquid);
  double fluid_speed(double time) const;    ///< m/s
  double cloth_speed(double time) const;    ///< m/s
  double cloth_stretch(double time) const;  ///< 1: an edge's length over that at rest
};

/// The liquid collapses: its mean compression stays above this, 1, for so many steps in a row while the density solve
/// does not converge. It then fills less than half of the volume that it should: more than any start that overlaps (the
/// solver parts it in a few steps) or any cap on the iterations leaves.
constexpr double collapse = 1;
constexpr int collapse_steps = 10;

}  // namespace drench
