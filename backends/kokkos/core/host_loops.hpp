#pragma once
// Which loops of a host are shared among its threads: those that take long enough. What a loop computes does not depend
// on it.

#include <atomic>
#include <chrono>
#include <cstdint>

#include "base/types.hpp"

namespace drench::kokkos_backend {

/// How many of the threads share loops (core/runtime.cpp); beside a GPU, those of host_parallel().
struct HostLoops {
  static inline int all = 1;
  static inline std::atomic<int> most{1};  // of a run
  static inline thread_local int own = 0;  // of the runs of this thread, where they have a limit of their own
  static int threads() { return own > 0 ? own : most.load(std::memory_order_relaxed); }
  /// A loop that takes less is not shared, ns: threads that spin are there within one or two µs, those that sleep after
  /// some 50.
  static inline float worth = 8e3F;
};

/// How long an item of a loop takes, as its last runs told; every loop in the code has one.
class LoopTime {
 public:
  bool is_worth_sharing(Index n) const {
    if (HostLoops::threads() == 1) return false;
    return known_ ? item_ * static_cast<float>(n) > HostLoops::worth : n > 1024;
  }
  /// Is this run to be timed? One of eight is.
  bool wants_time() { return (runs_++ & 7) == 0; }
  /// A run of n items took `ns` on so many threads. One that was interrupted counts as twice as long as before at most.
  void learn(Index n, double ns, int threads) {
    const float found = static_cast<float>(ns * threads / n);
    item_ = !known_ ? found : 0.75F * item_ + 0.25F * (found < 2 * item_ ? found : 2 * item_);
    known_ = true;
  }

 private:
  float item_ = 0;  // ns
  bool known_ = false;
  std::uint8_t runs_ = 0;
};

/// Runs alone() or together(), and learns how long n items took.
template <class Alone, class Together>
void run_timed(LoopTime& time, Index n, const Alone& alone, const Together& together) {
  const bool share = time.is_worth_sharing(n), timed = time.wants_time();
  const auto begin = timed ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
  if (share)
    together();
  else
    alone();
  if (timed)
    time.learn(n, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count(),
               share ? HostLoops::threads() : 1);
}

}  // namespace drench::kokkos_backend
