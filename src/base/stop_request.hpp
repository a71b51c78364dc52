#pragma once
// An orderly end that somebody has asked for, and the loops of a step that heed it before the step is done.

namespace drench {

/// A step is given up half-way because somebody has asked for an end. The state is that of half a step.
struct StepStopped {};

/// Asks for an end. A signal handler may call it.
void request_stop() noexcept;
/// Nobody has asked.
void forget_stop_request() noexcept;
bool stop_requested() noexcept;

/// While one lives, `stop_if_requested` may give up the step: somebody can restore the state before it.
class StoppableStep {
 public:
  explicit StoppableStep(bool stoppable) noexcept;
  ~StoppableStep();
  StoppableStep(const StoppableStep&) = delete;
  StoppableStep& operator=(const StoppableStep&) = delete;
};

/// For every loop of a step that may take long: throws StepStopped within a stoppable step once an end is asked for.
/// Costs nothing to speak of; not to be called by kernels.
void stop_if_requested();

}  // namespace drench
