#pragma once
// Sums on a GPU whose order is always the same (reduce.hpp).

#include <cstring>

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// Two sums of the same kind in one kernel: teams add up their terms, and the last one to finish what the teams have,
/// in their order.
template <class Sum, class First, class Second>
struct TeamSums {
  using Team = Teams::member_type;
  static constexpr Index threads = team_threads, most_teams = 512;
  using Scratch = Kokkos::View<Sum*, ExecSpace::scratch_memory_space, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
  static_assert((threads & (threads - 1)) == 0, "over_team halves them");
  static_assert(threads * sizeof(Sum) <= most_scratch(threads));

  Index n_first, n_second, first_teams, second_teams;
  First first;
  Second second;
  Sum* part;    // of each team
  Sum* result;  // two
  unsigned* finished;

  static Index teams(Index n) { return Kokkos::min(most_teams, (n + threads - 1) / threads); }

  /// What another team has left, past the first-level cache.
  KOKKOS_INLINE_FUNCTION Sum seen(Index team) const {
    constexpr std::size_t words = sizeof(Sum) / sizeof(double);
    double word[words];
    const volatile double* const from = reinterpret_cast<const volatile double*>(part + team);
    for (std::size_t k = 0; k < words; ++k) word[k] = from[k];
    Sum s;
    std::memcpy(&s, word, sizeof(Sum));
    return s;
  }
  /// The sum over a team's threads, in its first thread.
  KOKKOS_INLINE_FUNCTION static Sum over_team(const Team& team, const Scratch& room, const Sum& own) {
    const int rank = team.team_rank();
    room(rank) = own;
    for (int half = threads / 2; half > 0; half /= 2) {
      team.team_barrier();
      if (rank < half) room(rank) += room(rank + half);
    }
    const Sum sum = rank == 0 ? room(0) : own;
    team.team_barrier();
    return sum;
  }
  KOKKOS_INLINE_FUNCTION Sum of_parts(const Team& team, const Scratch& room, Index from, Index to) const {
    Sum own{};
    for (Index p = from + team.team_rank(); p < to; p += threads) own += seen(p);
    return over_team(team, room, own);
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Team& team) const {
    const Scratch room(team.team_scratch(0), static_cast<std::size_t>(threads));
    const Index rank = team.league_rank(), thread = team.team_rank(), all = first_teams + second_teams;
    Sum own{};
    if (rank < first_teams)
      for (Index i = rank * threads + thread; i < n_first; i += first_teams * threads) own += first(i);
    else
      for (Index i = (rank - first_teams) * threads + thread; i < n_second; i += second_teams * threads)
        own += second(i);
    const Sum sum = over_team(team, room, own);
    int last = 0;
    if (thread == 0) {
      part[rank] = sum;
      Kokkos::memory_fence();
      last = Kokkos::atomic_fetch_add(finished, 1u) == static_cast<unsigned>(all) - 1 ? 1 : 0;
    }
    team.team_broadcast(last, 0);
    if (last == 0) return;
    Kokkos::memory_fence();
    const Sum a = of_parts(team, room, 0, first_teams), b = of_parts(team, room, first_teams, all);
    if (thread != 0) return;
    result[0] = a;
    result[1] = b;
    *finished = 0;
  }
};

}  // namespace drench::kokkos_backend
