#pragma once
// A scene's set-up within the memory that there is.

#include <string>

#include "scene/build.hpp"

namespace drench {

/// What a run may take here: with the reference double precision in the host's memory, otherwise this build's precision in
/// its device's. Throws DeviceError without a device.
MemoryBudget memory_budget(bool reference = false);

/// "812.3 MiB"
std::string mebibytes(double bytes);

}  // namespace drench
