// What the backend's start says of a GPU whose threads do not run where kernels rely on it.

#include "core/thread_mapping.hpp"

#include <gtest/gtest.h>

namespace drench::test {
namespace {

using kokkos_backend::mapping_fault;
using kokkos_backend::team_threads;
using kokkos_backend::ThreadMapping;
using kokkos_backend::ThreadPlace;

constexpr Index lanes = 8;

/// Indexes on blocks of that many threads, one after the other.
std::vector<ThreadPlace> in_blocks(int indexes, int threads) {
  const int warps = (threads + 31) / 32;
  std::vector<ThreadPlace> places;
  for (int k = 0; k < indexes; ++k) {
    const int y = k % threads;
    places.push_back({k / threads * warps + y / 32, y % 32, y});
  }
  return places;
}

ThreadMapping as_expected() { return {32, 128, in_blocks(1000, 128), in_blocks(5 * team_threads, 128), {7, 7}}; }

bool says(const ThreadMapping& seen, const char* part) {
  const std::string fault = mapping_fault(seen, lanes);
  EXPECT_EQ(fault.find('\n'), std::string::npos);
  EXPECT_NE(fault.find("Kokkos"), std::string::npos) << fault;
  EXPECT_NE(fault.find(part), std::string::npos) << fault;
  return fault.find(part) != std::string::npos;
}

}  // namespace

TEST(thread_mapping, what_kernels_need_is_no_fault) {
  EXPECT_EQ(mapping_fault(as_expected(), lanes), "");
  for (const int threads : {32, 64, 96, 256, 1024, 8}) {  // Kokkos chooses a loop's block
    ThreadMapping seen = as_expected();
    seen.loop = in_blocks(1000, threads);
    EXPECT_EQ(mapping_fault(seen, lanes), "") << threads;
  }
  ThreadMapping seen = as_expected();
  for (ThreadPlace& place : seen.loop) place.warp = 1000 - place.warp;  // whichever block is first
  EXPECT_EQ(mapping_fault(seen, lanes), "");
}

TEST(thread_mapping, a_wrong_loop_is_found) {
  ThreadMapping seen = as_expected();
  seen.loop = in_blocks(1000, 12);  // a block ends within a row
  says(seen,
       "a loop's index 12 should run on lane 12 of warp 0 along threadIdx.y, but ran on lane 0 of warp 1, threadIdx.y "
       "0");
  seen.loop = in_blocks(1000, 1);  // KOKKOS_IMPL_DEBUG_CUDA_SERIAL_EXECUTION
  says(seen, "a loop's index 1 should run on lane 1 of warp 0");
  seen = as_expected();
  for (ThreadPlace& place : seen.loop) place.y = 0;  // along threadIdx.x
  says(seen,
       "a loop's index 1 should run on lane 1 of warp 0 along threadIdx.y, but ran on lane 1 of warp 0, threadIdx.y 0");
  seen = as_expected();
  std::swap(seen.loop[8], seen.loop[9]);
  says(seen, "a loop's index 8 should run on lane 8");
  seen = as_expected();
  seen.loop[999] = {};
  says(seen, "a loop's index 999 did not run");
}

TEST(thread_mapping, wrong_teams_warps_and_sums_are_found) {
  ThreadMapping seen = as_expected();
  seen.warp_size = 64;
  says(seen, "a warp should have 32 threads, but has 64");
  seen = as_expected();
  seen.team_size = 1;
  says(seen, "a team should have 128 threads, but has 1");
  seen = as_expected();
  seen.teams = in_blocks(5 * team_threads, 16);  // well enough for a loop
  says(seen, "teams' thread 16 should run on lane 16 of warp 0");
  seen = as_expected();
  seen.sum_order[1] = 8;
  says(seen, "a sum should always add in the same order");
}

}  // namespace drench::test
