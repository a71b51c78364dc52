// Small kernels with the policies of the others, which note where they run.

#include "core/thread_mapping.hpp"

#include "core/gather.hpp"
#include "core/reduce.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr const char* label = "drench::start::thread_mapping";
constexpr Index indexes = 1000, team_count = 5, terms = 65536;  // several blocks each; the loop's last one is not full
static_assert(indexes % row_lanes == 0);

template <class T>
using Seen = Kokkos::View<T*, Kokkos::SharedHostPinnedSpace>;

KOKKOS_INLINE_FUNCTION ThreadPlace place_of_thread() {
  ThreadPlace place;
#ifdef __CUDA_ARCH__
  const unsigned block = blockIdx.x + gridDim.x * (blockIdx.y + gridDim.y * blockIdx.z);
  const unsigned warps = (blockDim.x * blockDim.y * blockDim.z + warp_size - 1) / warp_size;
  const unsigned thread = threadIdx.x + blockDim.x * (threadIdx.y + blockDim.y * threadIdx.z);
  place.warp = static_cast<int>(block * warps + thread / warp_size);
  asm("mov.u32 %0, %%laneid;" : "=r"(place.lane));
  place.y = static_cast<int>(threadIdx.y);
#endif
  return place;
}

void look_at_loop(const Seen<ThreadPlace>& place) {
  parallel(
      label, indexes, KOKKOS_LAMBDA(const Index k) { place(k) = place_of_thread(); });
}

void look_at_teams(const Seen<ThreadPlace>& place, const Seen<int>& size) {
  Kokkos::parallel_for(
      label, Teams(exec(), team_count, team_threads), KOKKOS_LAMBDA(const Teams::member_type& team) {
        if (team.league_rank() == 0 && team.team_rank() == 0) size(0) = team.team_size();
        if (team.team_rank() < team_threads)
          place(team.league_rank() * team_threads + team.team_rank()) = place_of_thread();
      });
}

/// A sum that differs where terms are added in another order: a s + t + 1 is neither commutative nor associative.
struct OrderedSum {
  std::uint64_t hash = 0;
  KOKKOS_INLINE_FUNCTION OrderedSum& operator+=(const OrderedSum& o) {
    hash = 6364136223846793005u * hash + o.hash + 1;
    return *this;
  }
};
struct OrderedTerm {
  KOKKOS_INLINE_FUNCTION OrderedSum operator()(const Index i) const {
    return {0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(i + 1)};
  }
};

}  // namespace

std::string thread_mapping_fault() {
  const std::string name = label;
  const Seen<ThreadPlace> loop(name, indexes), teams(name, team_count * team_threads);
  const Seen<int> team_size(name, 1);
  const Seen<OrderedSum> sum(name, 2);
  look_at_loop(loop);
  look_at_teams(teams, team_size);
  for (int k = 0; k < 2; ++k) reduce_into(label, terms, Added<OrderedSum, OrderedTerm>{}, sum.data() + k);
  exec().fence(label);
  ThreadMapping seen{exec().cuda_device_prop().warpSize, team_size(0), {}, {}, {sum(0).hash, sum(1).hash}};
  seen.loop.assign(loop.data(), loop.data() + loop.extent(0));
  seen.teams.assign(teams.data(), teams.data() + teams.extent(0));
  return mapping_fault(seen, row_lanes);
}

}  // namespace drench::kokkos_backend
