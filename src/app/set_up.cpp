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

ForeseenMemory foresee_memory(const Setup& setup, int real_bytes) {
  ForeseenMemory memory;
  memory.size = size_of(setup);
  memory.start = estimate_memory(memory.size, real_bytes);
  const SetupSize later = with_sources(setup, memory.size);
  memory.added = later.fluid - memory.size.fluid;
  memory.least = estimate_memory(later, real_bytes).backend();
  memory.most = estimate_memory(at_worst(later), real_bytes).backend();
  return memory;
}

std::string mebibytes(double bytes) { return fmt::format("{:.1f} MiB", bytes / (1 << 20)); }

}  // namespace drench
