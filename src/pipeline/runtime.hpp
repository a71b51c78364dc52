#pragma once
// Start and end of the parallel runtime, its device and its memory, without naming them: the backend in this build
// implements it.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace drench {

/// No device, or one that this build cannot run on. One line.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws DeviceError unless there is a device for this build. Quick, and before anything else: needs no
/// BackendRuntime.
void require_device();

/// Do the kernels of this build run on the host's cores?
bool computes_on_host();

/// The memory that the backend's arrays lie in.
struct DeviceMemory {
  std::string device;  ///< its name; "" when the arrays lie in the host's own memory
  double total = 0;    ///< bytes
  double free = 0;     ///< bytes
};
/// The device's memory, as it is now. Needs no BackendRuntime.
DeviceMemory device_memory();

/// Text of a DeviceError, one line: there is no device, for the `reason` that its driver gives. `built_for` is a
/// compute capability, 90 for 9.0.
std::string no_device_text(std::string_view reason, int built_for);
/// Text of a DeviceError, one line: `device` has the compute capability `has`, and this build is for `built_for`.
std::string wrong_device_text(std::string_view device, int has, int built_for);

/// The runtime of this build's backend, one for the whole program. It must outlive every Backend and Simulation.
struct BackendRuntime {
  /// Starts it.
  /// @param threads number of threads; 0 or less leaves it to the runtime
  /// @param quiet silences the runtime's own notices
  /// @throws std::runtime_error when it cannot start
  explicit BackendRuntime(int threads, bool quiet);
  ~BackendRuntime();
  BackendRuntime(const BackendRuntime&) = delete;
  BackendRuntime& operator=(const BackendRuntime&) = delete;
};

/// The threads of a build for the host; 1 for a GPU's.
int loop_threads();
/// How many threads share a loop of the host now: as share_loops() says, and in a thread with OwnLoops those.
int shared_loops();
/// How many runs may compute at a time, each in a thread: as many as threads share loops, or for a GPU as many as keep
/// it busy.
int runs_at_a_time();
/// How many threads share the loops of a run. It may change between any two steps, for results do not depend on it.
void share_loops(int threads);
/// As long as it lives, loops of the thread that made it are shared among so many threads, whatever share_loops() says.
class OwnLoops {
 public:
  explicit OwnLoops(int threads);
  ~OwnLoops();
  OwnLoops(const OwnLoops&) = delete;
  OwnLoops& operator=(const OwnLoops&) = delete;

 private:
  int before_;
};
/// What all of them get of the cores now, in cores; takes 30 ms (base/free_cores.hpp).
double loop_cores();

/// Bytes of all arrays in the backend's own memory. Every allocation of the runtime counts, scratch included.
struct ArrayMemory {
  std::int64_t now = 0;   ///< bytes
  std::int64_t peak = 0;  ///< bytes, since the first BackendRuntime began
};
/// The backend's arrays, as they are now.
ArrayMemory array_memory();

/// Arrays of the backend that have one name, together.
struct NamedArray {
  std::string name;
  std::int64_t bytes = 0;
};
/// The backend's arrays as they are now, the largest first.
std::vector<NamedArray> named_arrays();

/// Lines of `name: value`: the execution space, device, memory, threads and library versions. Only while a
/// BackendRuntime lives.
std::string runtime_description();

}  // namespace drench
