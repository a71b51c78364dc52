#pragma once

#include <chrono>
#include <cstdint>

#include "pipeline/backend.hpp"

namespace drench {

/// What a person sees on stdout during a run: on a terminal one line that is rewritten, otherwise a line every 5 s.
class Progress {
 public:
  /// The run goes from `start` to `end` seconds and stops after `max_steps` steps (< 0: no such bound).
  Progress(bool quiet, double start, double end, std::int64_t max_steps);
  /// `steps_done` counts this run's steps; `mass_error` in kg.
  void update(double time, std::int64_t step, std::int64_t steps_done, const StepReport& report, double mass_error);
  /// Leaves the line, so that other text can follow.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_, line_open_ = false;
  double start_, end_;
  std::int64_t max_steps_;
  Clock::time_point begin_, last_;
};

}  // namespace drench
