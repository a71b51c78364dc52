#pragma once
// What the validation tests share: a number beside its target, printed so that tools/validate can make a table of it.

#include <memory>
#include <string>
#include <vector>

#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "setup/build.hpp"

namespace drench::test {

inline const double rounding = double_precision ? 2.3e-16 : 1.2e-7;  // ε of the backend's precision

/// Today's bounds of a target that is missed, one a precision: each at most 1.1 times what is measured, 0 where it is
/// met.
struct Reached {
  double in_float = 0;
  double in_double = 0;
  /// Where rounding decides the outcome, the worst that is known of other backends and roundings: bounds may be 1.1
  /// times that, and are then allowed where this run meets the target. 0: the outcome is the same everywhere.
  double scatter = 0;

  double bound(bool of_double = double_precision) const { return of_double ? in_double : in_float; }
};

/// One row of docs/validation/: the same `what` in float and in double, for they share the row.
struct Finding {
  std::string what;       ///< the case and the quantity; no measured number
  std::string reference;  ///< the theory or the measurement
  double measured = 0;
  double target = 0;  ///< the largest value allowed
  std::string unit = "1";
  Reached reached{};     ///< where the target is missed
  std::string reason{};  ///< why it is missed: one short sentence, printed only then

  bool met() const { return measured <= target; }  ///< a number that is not finite meets nothing
};

/// How much higher than the worst measured number a bound may be.
inline constexpr double allowed_slack = 0.1;

/// What is wrong with a row, a line each; nothing if it is as it should be: met without a bound, or missed with a
/// reason and within a bound that is at most `allowed_slack` above the measured number. `exact`: this run is of the
/// kind that bounds are set from; others only have to keep them.
std::vector<std::string> objections(const Finding& finding, bool of_double, bool exact);

/// Prints a row for tools/validate (tests/validation/themes.txt has the suite's page), and expects no objections.
/// Bounds are set from the host's runs; a GPU's only have to keep them, and tools/validate compares them over all its
/// logs.
void report(const Finding& finding);

/// A scene on the Kokkos backend, stepped by hand.
class SceneRun {
 public:
  explicit SceneRun(const std::string& yaml);
  StepReport step(double time_left = 1e9) { return last_ = pipeline_->step(time_left); }
  HostState state() const;  ///< all of it, on every rank
  double time() const { return pipeline_->time(); }
  double dt() const { return last_.dt; }  ///< s, of the last step
  const Model& model() const { return setup_.model; }
  const HostState& initial() const { return setup_.state; }
  /// Goes on from a state that the test has edited.
  void restart(const HostState& from);

 private:
  drench::Setup setup_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Pipeline> pipeline_;
  StepReport last_;
};

/// The particle's mass in kg.
double kilograms(const Model& model, Quanta mass);

}  // namespace drench::test
