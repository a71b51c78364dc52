#pragma once
// A scene's set-up within the memory that there is.

#include <string>

#include "setup/build.hpp"

namespace drench {

/// What a run may take here: with the reference double precision in the host's memory, otherwise this build's precision in
/// its device's. Throws DeviceError without a device.
MemoryBudget memory_budget(bool reference = false);

/// What a run may take in the host's memory. The arrays are the Kokkos backend's, also for the reference, which tells none.
MemoryBudget host_memory_budget(int real_bytes);

/// Bytes that the backend's arrays take: at the start, with all particles that jets and cloths add, and where liquid crowds
/// and cloth folds besides.
struct ForeseenMemory {
  SetupSize size;  // at the start
  MemoryEstimate start;
  double added = 0;            // particles
  double end = 0, folded = 0;  // bytes of the backend
  bool grows() const { return end > 1.01 * start.backend(); }
  bool folds() const { return folded > 1.01 * end; }
  /// ", 12.3 MiB in the end, 15.4 MiB in folds", as far as these differ from the start.
  std::string later() const;
};
ForeseenMemory foresee_memory(const Setup& setup, const MemoryBudget& budget);

/// "812.3 MiB"
std::string mebibytes(double bytes);

}  // namespace drench
