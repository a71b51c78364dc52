#include "base/stop_request.hpp"

#include <atomic>

namespace drench {
namespace {

std::atomic<bool> requested{false}, may_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

}  // namespace

void request_stop() noexcept { requested.store(true, std::memory_order_relaxed); }

void forget_stop_request() noexcept { requested.store(false, std::memory_order_relaxed); }

bool stop_requested() noexcept { return requested.load(std::memory_order_relaxed); }

StoppableStep::StoppableStep(bool stoppable) noexcept { may_stop.store(stoppable, std::memory_order_relaxed); }

StoppableStep::~StoppableStep() { may_stop.store(false, std::memory_order_relaxed); }

void stop_if_requested() {
  if (stop_requested() && may_stop.load(std::memory_order_relaxed)) throw StepStopped{};
}

}  // namespace drench
