#include "app/threads.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/free_cores.hpp"

namespace drench {
namespace {

/// Was the program started by itself, and not as an argument of the dynamic loader?
bool can_start_anew() {
  std::error_code failed;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
  return !failed && !self.filename().string().starts_with("ld-");
}

}  // namespace

void settle_threads(char** argv, int asked, bool quiet) {
  // The warning of Kokkos asks for binding, which helps no run of ours and harms where cores are shared.
  setenv("OMP_PROC_BIND", "false", 0);
  if (std::getenv("OMP_WAIT_POLICY") != nullptr || std::getenv("GOMP_SPINCOUNT") != nullptr || !can_start_anew()) return;
  const int cores = allowed_cores();
  if (asked <= 0)
    if (const char* given = std::getenv("OMP_NUM_THREADS")) asked = std::atoi(given);
  if (cores == 1 || asked == 1) return;
  const double free = free_cores();
  const int threads = asked > 0 ? asked : threads_for(free, cores);
  if (asked <= 0 && threads < cores && !quiet)
    fmt::print(stderr, "other programs keep {} of {} cores busy: {} {} (--threads N asks for more)\n", cores - threads, cores,
               threads, threads == 1 ? "thread" : "threads");
  setenv("OMP_NUM_THREADS", std::to_string(threads).c_str(), 1);
  setenv("OMP_WAIT_POLICY", threads <= threads_for(free, cores) ? "active" : "passive", 1);
  std::fflush(nullptr);
  execv("/proc/self/exe", argv);
}

}  // namespace drench
