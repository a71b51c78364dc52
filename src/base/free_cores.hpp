#pragma once
// How many of the machine's cores a run can have.

#include <optional>

namespace drench {

/// Cores that this process is allowed to use: by its affinity, and by the quota of its control group.
int allowed_cores();

/// Kokkos' OpenMP backend has room for so many; with more it would write beyond its tables.
inline constexpr int most_threads = 512;

/// Threads for work on the host that goes on beside no other: OMP_NUM_THREADS if the environment has it, else
/// allowed_cores(); at most most_threads.
int host_threads();

/// Cores of a control group's file cpu.max, "quota period" in µs; 0 where it sets no limit.
double quota_cores(const char* cpu_max);

/// What other programs take of the cores that this process may use.
class OtherPrograms {
 public:
  OtherPrograms();
  /// Cores that they kept busy since the last call, on average. Nothing where the machine does not tell.
  std::optional<double> busy_cores();

 private:
  double others_, now_;  // s
};

/// What a thread gets of a core now, 1 at most: it spins for 30 ms and tells how long it ran.
double share_of_core();

/// What it gets of them now, in cores: a thread on each spins for 30 ms and tells how long it ran.
double free_cores();

/// Threads for so many free cores, of `cores`; at least 1. Three quarters of a core count as one.
int threads_for(double free, int cores);

}  // namespace drench
