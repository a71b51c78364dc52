#pragma once
// A scene's set-up within the memory that there is.

#include <string>

#include "setup/build.hpp"
#include "setup/rank_share.hpp"

namespace drench {

/// What a run may take here: with the reference double precision in the host's memory, otherwise this build's precision
/// in its device's. Throws DeviceError without a device.
MemoryBudget memory_budget(bool reference = false);

/// The same for one of `ranks` that run the scene together, as its liquid will lie (setup/rank_share.hpp).
MemoryBudget memory_budget_of_rank(MemoryBudget budget, const RankShare& share);
/// How the liquid of a set-up lies on ranks as it begins; as it is expected to where there is none yet.
SpreadLiquid spread_over_ranks(const Setup& setup, int ranks);
RankShare share_of_rank(const Setup& setup, int ranks);
/// Of a scene that is not set up yet.
RankShare share_of_rank(const Scene& scene, int ranks);

/// What a run may take in the host's memory. The arrays are the Kokkos backend's, also for the reference, which tells
/// none.
MemoryBudget host_memory_budget(int real_bytes);

/// Bytes that the backend's arrays take: at the start, with all particles that jets and cloths add, and where liquid
/// crowds and cloth folds besides.
struct ForeseenMemory {
  SetupSize size;  // at the start
  MemoryEstimate start;
  double added = 0;            // particles
  double end = 0, folded = 0;  // bytes of the backend
  bool grows() const { return end > 1.01 * start.backend(); }
  bool folds() const { return folded > 1.01 * end; }
  /// ", 12.3 MiB in the end, 15.4 MiB in folds", as far as these differ from the start.
  std::string later() const;
  /// A warning where liquid that comes later will not fit; "" where it does.
  std::string too_large_later(const MemoryBudget& budget) const;
};
ForeseenMemory foresee_memory(const Setup& setup, const MemoryBudget& budget);

/// "812.3 MiB"
std::string mebibytes(double bytes);

}  // namespace drench
