#include "app/set_up.hpp"

#include <fmt/format.h>

#include "drench_version.hpp"
#include "pipeline/runtime.hpp"

namespace drench {

MemoryBudget memory_budget(bool reference) {
  MemoryBudget budget;
  if (reference) {
    budget.real_bytes = 8;
    return budget;
  }
  budget.real_bytes = precision_name == "double" ? 8 : 4;
  require_device();
  const DeviceMemory memory = device_memory();
  budget.device = memory.device;
  budget.device_free = memory.free;
  return budget;
}

std::string mebibytes(double bytes) { return fmt::format("{:.1f} MiB", bytes / (1 << 20)); }

}  // namespace drench
