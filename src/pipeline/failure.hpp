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
  solute,         // the same of the solute
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

/// m/s: the fastest that the scene prescribes, or did: wind, a source, a pin, a point of a body.
double fastest_prescribed(const Model& model);

/// Bounds that a run exceeds only when it diverges; formulas: docs/dev/run_limits.md. They are wide because a
/// false alarm ends a good run, and a divergence grows by orders of magnitude within a few steps. They grow with the
/// run's time, so that they are narrow where a run that starts badly needs them.
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
  /// Something prescribed moves at this speed, m/s.
  void expect(double speed) { scale = speed > scale ? speed : scale; }
  double fluid_speed(double time) const;    ///< m/s
  double cloth_speed(double time) const;    ///< m/s
  double cloth_stretch(double time) const;  ///< 1: an edge's length over that at rest
};

/// The liquid collapses: its mean compression stays above this, 1, for so many steps in a row while the density solve
/// does not converge. It then fills less than half of the volume that it should. No start that overlaps and no cap on
/// the iterations leaves that much: the solver separates overlapping particles in a few steps.
constexpr double collapse = 1;
constexpr int collapse_steps = 10;

}  // namespace drench
