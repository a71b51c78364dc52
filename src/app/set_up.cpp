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

ForeseenMemory foresee_memory(const Setup& setup, const MemoryBudget& budget) {
  const int real_bytes = budget.real_bytes;
  const bool gpu = !budget.device.empty();
  ForeseenMemory memory;
  memory.size = size_of(setup);
  memory.start = estimate_memory(memory.size, real_bytes, gpu);
  const SetupSize later = with_sources(setup, memory.size);
  memory.added = jet_particles(setup.model) + dripping_particles(setup);
  const SetupSize end = at_work(later);
  memory.end = estimate_memory(end, real_bytes, gpu).backend();
  memory.folded = estimate_memory(in_folds(end), real_bytes, gpu).backend();
  return memory;
}

std::string ForeseenMemory::later() const {
  std::string text;
  if (grows()) text += fmt::format(", {} in the end", mebibytes(end));
  if (folds()) text += fmt::format(", {} in folds", mebibytes(folded));
  return text;
}

std::string mebibytes(double bytes) { return fmt::format("{:.1f} MiB", bytes / (1 << 20)); }

}  // namespace drench
