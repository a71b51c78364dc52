#pragma once
// Start and end of the parallel runtime, its device and its memory, without naming them: the backend in this build implements it.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace drench {

/// No device, or one that this build cannot run on. One line.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws DeviceError unless there is a device for this build. Quick, and before anything else: needs no BackendRuntime.
void require_device();

/// The memory that the backend's arrays lie in, bytes. `device` is its name, "" when it is the host's own memory. Needs no
/// BackendRuntime.
struct DeviceMemory {
  std::string device;
  double total = 0, free = 0;
};
DeviceMemory device_memory();

/// What is wrong with the device, in one line: the text of a DeviceError. `built_for` and `has` are compute capabilities,
/// 90 for 9.0.
std::string no_device_text(std::string_view reason, int built_for);
std::string wrong_device_text(std::string_view device, int has, int built_for);

/// Starts the runtime of this build's backend for the whole program; the destructor ends it, after every Backend is
/// gone. `threads` ≤ 0 leaves the number to the runtime. `quiet` silences its own notices. Errors are
/// std::runtime_error.
struct BackendRuntime {
  explicit BackendRuntime(int threads, bool quiet);
  ~BackendRuntime();
  BackendRuntime(const BackendRuntime&) = delete;
  BackendRuntime& operator=(const BackendRuntime&) = delete;
};

/// Bytes of all arrays that the backend holds in its own memory, now and at most so far, since the first BackendRuntime
/// began: every allocation of the runtime counts, scratch included.
struct ArrayMemory {
  std::int64_t now = 0, peak = 0;
};
ArrayMemory array_memory();

/// Lines of `name: value`: the execution space, device, memory, threads and library versions. Only while a BackendRuntime
/// lives.
std::string runtime_description();

}  // namespace drench
