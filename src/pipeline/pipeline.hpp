#pragma once
// Which stages a scene needs, in which order, with their timers: written once, drives every backend.

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "pipeline/backend.hpp"
#include "pipeline/failure.hpp"
#include "setup/baked_liquid.hpp"

namespace drench {

/// The stages that the model needs, in the order of DRENCH_STAGES.
std::vector<Stage> stages_for(const Model& model);

class Pipeline {
 public:
  Pipeline(const Model& model, Backend& backend, const HostState& initial);
  /// One step; `time_left` bounds Δt so that a step ends exactly at the next output time.
  /// Throws RunFailure (failure.hpp), and StepStopped (base/stop_request.hpp) if an end is asked for during a step
  /// whose beginning is kept; the state is then again as it was before the step.
  StepReport step(double time_left);
  const std::vector<Stage>& stages() const { return stages_; }
  double time() const { return time_; }
  std::int64_t step_index() const { return step_; }
  /// The model's pins, jets or wind have changed: finds anew which stages it needs, and what is too fast.
  void model_changed();
  /// Goes on from another state of the same model.
  void go_on_from(const HostState& state);
  /// Sets what a state knows of the run beside what the backend downloads.
  void mark(HostState& state) const;
  Quanta initial_total() const { return initial_total_; }
  Quanta initial_solute() const { return initial_solute_; }
  /// Milliseconds that each stage took in the last step, by stage number. A fence ends each stage only when profiling.
  const std::array<double, stage_count>& milliseconds() const { return milliseconds_; }
  /// Milliseconds of wall time that the whole last step took.
  double step_milliseconds() const { return step_milliseconds_; }
  void set_profiling(bool on) { profiling_ = on; }
  /// Keeps the state before a step that may take long, so that step() can give it up. `now`: the state as it is, for
  /// the first step; it must outlive the pipeline.
  void set_stoppable(const HostState& now) {
    stoppable_ = true;
    first_state_ = &now;
  }

 private:
  /// All stages, in a step that is at most so long; nothing of the pipeline's own changes but the timers.
  StepReport attempt(double time_left, double longest);
  /// time.mode error: the longest step that leaves little enough, and how long the next one may be.
  StepReport step_by_error(double time_left);
  void run(Stage stage, const StepInfo& info, StepReport& report);
  /// At the end of a step: the particles of the file whose time it is.
  void take_file();
  /// Can the step that begins be given up? Keeps the state for that.
  bool keep_for_stop();
  void take_back();
  bool have_looked(Stage stage) const;
  void check(const StepInfo& info, const StepReport& report);
  /// ½ Δt times the change of the rate at which cloth takes up liquid, over what all of it holds when full, 1.
  double saturation_error(const StepReport& report);

  const Model& model_;
  Backend& backend_;
  std::vector<Stage> stages_;
  std::array<double, stage_count> milliseconds_{};
  double time_ = 0, step_milliseconds_ = 0;
  std::int64_t step_ = 0;
  Quanta initial_total_ = 0, initial_solute_ = 0;
  Limits limits_;
  std::optional<BakedLiquid> baked_;
  double fastest_file_ = 0;  // m/s, of all files so far
  Carried carried_;
  Quanta in_cloth_ = 0;  // after the last step
  double capacity_ = 0;  // kg, of all cloth
  bool looked_ = false;  // lists and densities are of the state as it is
  bool profiling_ = false, stoppable_ = false;
  const HostState* first_state_ = nullptr;  // before the first step, where that can be given up
};

}  // namespace drench
