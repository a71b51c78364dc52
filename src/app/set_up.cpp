#include "app/set_up.hpp"

#include <fmt/format.h>

#include "drench_version.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/runtime.hpp"

namespace drench {

namespace {

MemoryBudget budget_with(int real_bytes, const DeviceMemory& memory) {
  MemoryBudget budget;
  budget.real_bytes = real_bytes;
  budget.device = memory.device;
  budget.device_free = memory.free;
  const bool gpu = !memory.device.empty();
  budget.arrays = [=](const SetupSize& size) { return kokkos_array_bytes(size, real_bytes, gpu); };
  return budget;
}

}  // namespace

MemoryBudget memory_budget(bool reference) {
  if (reference) return host_memory_budget(8);
  require_device();
  return budget_with(precision_name == "double" ? 8 : 4, device_memory());
}

MemoryBudget host_memory_budget(int real_bytes) { return budget_with(real_bytes, {}); }

ForeseenMemory foresee_memory(const Setup& setup, const MemoryBudget& budget) {
  ForeseenMemory memory;
  memory.size = size_of(setup);
  memory.start = estimate_memory(memory.size, budget.arrays);
  const SetupSize later = with_sources(setup, memory.size);
  memory.added = jet_particles(setup.model) + dripping_particles(setup);
  const SetupSize end = at_work(later);
  memory.end = estimate_memory(end, budget.arrays).backend();
  memory.folded = estimate_memory(in_folds(end), budget.arrays).backend();
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
