#include "app/set_up.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/version.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/rank_memory.hpp"
#include "pipeline/runtime.hpp"

namespace drench {

namespace {

/// Of the layer of ghosts, m: h, and beside cloth the longest edge of its triangles more.
double halo_width(const Model& model) {
  double longest = 0;
  if (model.has_fluid())
    for (const auto& triangle : model.mesh.triangle)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& a = model.mesh.rest_position[static_cast<std::size_t>(triangle[k])];
        const Vec3& b = model.mesh.rest_position[static_cast<std::size_t>(triangle[(k + 1) % 3])];
        longest = std::max(longest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
      }
  return 1.0001 * (model.support + longest);  // Exchange::find_ghosts
}

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

MemoryBudget memory_budget_of_rank(MemoryBudget budget, const RankShare& share) {
  if (share.ranks == 1 || !budget.arrays) return budget;
  const int real_bytes = budget.real_bytes;
  const bool gpu = !budget.device.empty();
  budget.arrays = [=](const SetupSize& size) {
    return kokkos_rank_bytes(size, share.part * size.fluid, share.ghosts(size.fluid), real_bytes, gpu);
  };
  return budget;
}

SpreadLiquid spread_over_ranks(const Setup& setup, int ranks) {
  return spread(setup.state.fluid_position, ranks, halo_width(setup.model));
}

RankShare share_of_rank(const Setup& setup, int ranks) {
  if (setup.state.fluid_position.empty()) return expected_share(ranks, halo_width(setup.model) / setup.model.spacing);
  return spread_over_ranks(setup, ranks).fullest();
}

RankShare share_of_rank(const Scene& scene, int ranks) { return expected_share(ranks, scene.fluid.support); }

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
  if (grows()) text += fmt::format(", {} at the end", mebibytes(end));
  if (folds()) text += fmt::format(", {} with folded cloth", mebibytes(folded));
  return text;
}

std::string ForeseenMemory::too_large_later(const MemoryBudget& budget) const {
  const double free = budget.device.empty() ? budget.host : budget.device_free;
  if (!(end > free)) return "";
  return fmt::format(
      "with {:.0f} more particles the scene needs about {}, {} has {}: the run will end early; use a larger "
      "fluid.spacing, or emitters with less liquid",
      added, mebibytes(end), budget.device.empty() ? "the machine" : budget.device, mebibytes(free));
}

std::string mebibytes(double bytes) { return fmt::format("{:.1f} MiB", bytes / (1 << 20)); }

}  // namespace drench
