#pragma once
// How many threads a run on the host's cores has, and how they wait for each other.

#include <string>

#include "base/free_cores.hpp"

namespace drench {

/// For a build that computes on the host: unless the environment says so, threads are as many as there are cores
/// (`asked` > 0: as many as that). Those that have no core at the start wait until one is free. Threads that have one
/// wait by spinning. OpenMP's runtime reads that from the environment when a program starts, so the program is started
/// anew, with the same arguments. Returns where nothing is to be changed, or cannot be.
void settle_threads(char** argv, int asked);

/// Looks between the steps of a run whether its threads still have a core each. Where other programs have come, fewer
/// threads work until they have gone: threads that wait for one that has no core are slower than one alone. If the
/// environment defines how threads wait, their number does not change.
class ThreadWatch {
 public:
  ThreadWatch();
  /// A line for the user where threads wait for a core now; empty where all have one.
  std::string waiting() const;
  /// To be called between two steps.
  void look();

 private:
  void judge(double now);
  int threads_with_cores(double now);

  int all_, threads_;
  OtherPrograms others_;
  double begin_ = 0, next_ = 0;        // s: when it last looked, when it looks again
  double next_probe_ = 0, pause_ = 0;  // s: when threads may spin again to find free cores, and what lies between
  long interrupted_ = 0;               // times that a thread lost its core, to another program or to one of its own
};

}  // namespace drench
