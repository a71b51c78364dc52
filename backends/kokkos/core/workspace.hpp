#pragma once
// What the kernels of one run share, so that runs of several threads do not meet in it.

#include <optional>
#include <utility>
#include <vector>

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// Room for partial sums of any kind, in words of 8 bytes; grows on demand.
struct SumRoom {
  Array<double> many;
  Kokkos::View<double*, Kokkos::SharedHostPinnedSpace> few;
  Kokkos::View<unsigned, MemSpace> finished;  // teams
  Kokkos::View<double, Kokkos::SharedHostPinnedSpace> maximum[3];
};

/// Each backend has one, which is the current one of every thread that computes for it. Outside any backend there is
/// one of the process, freed with Kokkos, for code that only one thread runs.
struct Workspace {
  /// `space`: where its kernels run on a GPU; on a CPU it has spaces of its own for each number of threads.
  explicit Workspace(ExecSpace space) : own(std::move(space)) {}
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  SumRoom sums;
  std::optional<ExecSpace> own;
  std::vector<std::optional<ExecSpace>> spaces;  // by the number of a host's threads (space_of)

  static Workspace& current();
};

/// A space whose kernels wait for none of another space.
ExecSpace new_space();

/// Makes a workspace the current one of this thread, as long as it lives.
class CurrentWorkspace {
 public:
  explicit CurrentWorkspace(Workspace& workspace);
  ~CurrentWorkspace();
  CurrentWorkspace(const CurrentWorkspace&) = delete;
  CurrentWorkspace& operator=(const CurrentWorkspace&) = delete;

 private:
  Workspace* before_;
};

}  // namespace drench::kokkos_backend
