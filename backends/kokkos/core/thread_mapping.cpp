#include "core/thread_mapping.hpp"

#include <fmt/format.h>

namespace drench::kokkos_backend {
namespace {

/// Every `group` indexes should lie side by side in one warp, along threadIdx.y.
std::string fault_of_places(const char* of, const std::vector<ThreadPlace>& places, Index group) {
  for (Index k = 0; k < static_cast<Index>(places.size()); ++k) {
    const ThreadPlace &own = places[static_cast<std::size_t>(k)],
                      &first = places[static_cast<std::size_t>(k - k % group)];
    if (own.warp < 0) return fmt::format("{} {} did not run", of, k);
    const int lane = first.lane / group * group + k % group;
    if (own.warp == first.warp && own.lane == lane && own.y % warp_size == lane) continue;
    return fmt::format(
        "{} {} should run on lane {} of warp {} along threadIdx.y, but ran on lane {} of warp {}, threadIdx.y {}", of,
        k, lane, first.warp, own.lane, own.warp, own.y);
  }
  return "";
}

std::string fault(const ThreadMapping& seen, Index lanes) {
  if (seen.warp_size != warp_size)
    return fmt::format("a warp should have {} threads, but has {}", warp_size, seen.warp_size);
  if (seen.team_size != team_threads)
    return fmt::format("a team should have {} threads, but has {}", team_threads, seen.team_size);
  if (std::string of_loop = fault_of_places("a loop's index", seen.loop, lanes); !of_loop.empty()) return of_loop;
  if (std::string of_teams = fault_of_places("teams' thread", seen.teams, warp_size); !of_teams.empty())
    return of_teams;
  if (seen.sum_order[0] != seen.sum_order[1]) return "a sum should always add in the same order, but did not";
  return "";
}

}  // namespace

std::string mapping_fault(const ThreadMapping& seen, Index lanes) {
  const std::string what = fault(seen, lanes);
  if (what.empty()) return "";
  return fmt::format(
      "GPU threads: {} (Kokkos {}.{}.{}); build with a Kokkos that CMake fetches, "
      "-DCMAKE_DISABLE_FIND_PACKAGE_Kokkos=ON, "
      "or take --backend reference",
      what, KOKKOS_VERSION / 10000, KOKKOS_VERSION / 100 % 100, KOKKOS_VERSION % 100);
}

}  // namespace drench::kokkos_backend
