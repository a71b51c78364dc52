#pragma once
// A scene's set-up within the memory that there is.

#include <string>

#include "scene/build.hpp"

namespace drench {

/// What a run may take here: with the reference double precision in the host's memory, otherwise this build's precision in
/// its device's. Throws DeviceError without a device.
MemoryBudget memory_budget(bool reference = false);

/// Bytes that the backend's arrays take: at the start, with all particles that jets and cloths add, and where liquid crowds
/// and cloth folds besides.
struct ForeseenMemory {
  SetupSize size;  // at the start
  MemoryEstimate start;
  double added = 0;  // particles
  double least = 0, most = 0;
  bool grows() const { return most > 1.01 * start.backend(); }
};
ForeseenMemory foresee_memory(const Setup& setup, int real_bytes);

/// "812.3 MiB"
std::string mebibytes(double bytes);

}  // namespace drench
