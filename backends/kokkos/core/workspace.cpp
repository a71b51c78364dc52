#include "core/workspace.hpp"

#include <utility>

namespace drench::kokkos_backend {
namespace {

thread_local Workspace* current_workspace = nullptr;

Workspace& of_process() {
  static Workspace workspace{ExecSpace()};
  static const bool hooked = [] {
    Kokkos::push_finalize_hook([] {
      workspace.sums = {};
      workspace.own.reset();
      workspace.spaces.clear();
    });
    return true;
  }();
  (void)hooked;
  return workspace;
}

}  // namespace

Workspace& Workspace::current() { return current_workspace ? *current_workspace : of_process(); }

CurrentWorkspace::CurrentWorkspace(Workspace& workspace) : before_(std::exchange(current_workspace, &workspace)) {}
CurrentWorkspace::~CurrentWorkspace() { current_workspace = before_; }

ExecSpace new_space() {
#ifdef KOKKOS_ENABLE_CUDA
  return Kokkos::Experimental::partition_space(ExecSpace(), 1)[0];
#else
  return {};
#endif
}

const ExecSpace& space_of(int threads) {
  std::vector<std::optional<ExecSpace>>& spaces = Workspace::current().spaces;
  if (spaces.empty()) spaces.resize(static_cast<std::size_t>(ExecSpace().concurrency()) + 1);
  std::optional<ExecSpace>& space = spaces[static_cast<std::size_t>(threads)];
  if (!space) {
#if defined(KOKKOS_ENABLE_OPENMP) && !defined(KOKKOS_ENABLE_CUDA)
    if (threads < ExecSpace().concurrency()) space.emplace(threads);
#endif
    if (!space) space.emplace();
  }
  return *space;
}

ExecSpace exec() {
  if constexpr (on_host) return space_of(HostLoops::threads());
  return *Workspace::current().own;
}

}  // namespace drench::kokkos_backend
