#pragma once
// What the validation tests share: a number beside its target, printed so that tools/validate can make a table of it.

#include <memory>
#include <string>
#include <vector>

#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "setup/build.hpp"

namespace drench::test {

inline constexpr double rounding = double_precision ? 2.3e-16 : 1.2e-7;  // ε of the backend's precision

/// One row of docs/validation/: the same `what` in float and in double, for they share the row.
struct Finding {
  std::string what;       ///< the case and the quantity; no measured number
  std::string reference;  ///< the theory or the measurement
  double measured = 0;
  double target = 0;  ///< the largest value allowed
  std::string unit = "1";
  double reached = 0;    ///< where the target is missed: the bound that holds today; 0 if it is met
  std::string reason{};  ///< why it is missed: one short sentence, printed only then
};

/// Prints a row for tools/validate (tests/validation/themes.txt has the suite's page).
/// Expects measured ≤ target, or measured ≤ reached where that is set; a target may be missed only with a reason.
void report(const Finding& finding);

/// A scene on the Kokkos backend, stepped by hand.
class SceneRun {
 public:
  explicit SceneRun(const std::string& yaml);
  StepReport step(double time_left = 1e9) { return last_ = pipeline_->step(time_left); }
  HostState state() const { return backend_->download(); }
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
