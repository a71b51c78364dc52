#pragma once
// Start and end of the parallel runtime, without naming it: the backend in this build implements it.

#include <string>

namespace drench {

/// Starts the runtime of this build's backend for the whole program; the destructor ends it, after every Backend is
/// gone. `threads` ≤ 0 leaves the number to the runtime. `quiet` silences its own notices. Errors are
/// std::runtime_error.
struct BackendRuntime {
  explicit BackendRuntime(int threads, bool quiet);
  ~BackendRuntime();
  BackendRuntime(const BackendRuntime&) = delete;
  BackendRuntime& operator=(const BackendRuntime&) = delete;
};

/// Lines of `name: value`: the execution space, device, threads and library versions. Only while a BackendRuntime
/// lives.
std::string runtime_description();

}  // namespace drench
