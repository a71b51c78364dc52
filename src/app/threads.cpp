#include "app/threads.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace drench {
namespace {

int allowed_cores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
}

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Was the program started by itself, and not as an argument of the dynamic loader?
bool can_start_anew() {
  std::error_code failed;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
  return !failed && !self.filename().string().starts_with("ld-");
}

}  // namespace

double free_cores() {
  constexpr double probe = 0.03;  // s
  const int cores = allowed_cores();
  std::vector<double> share(static_cast<std::size_t>(cores), 0.0);
  std::vector<std::thread> threads;
  for (double& own : share)
    threads.emplace_back([&own] {
      const double start = seconds(CLOCK_MONOTONIC), spent = seconds(CLOCK_THREAD_CPUTIME_ID);
      double now = start;
      while (now < start + probe) now = seconds(CLOCK_MONOTONIC);
      own = (seconds(CLOCK_THREAD_CPUTIME_ID) - spent) / (now - start);
    });
  for (std::thread& t : threads) t.join();
  double sum = 0;
  for (const double own : share) sum += own;
  return sum;
}

int threads_for(double free, int cores) { return std::clamp(static_cast<int>(free + 0.25), 1, std::max(1, cores)); }

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
  setenv("OMP_NUM_THREADS", std::to_string(threads).c_str(), 0);
  setenv("OMP_WAIT_POLICY", threads <= threads_for(free, cores) ? "active" : "passive", 1);
  std::fflush(nullptr);
  execv("/proc/self/exe", argv);
}

}  // namespace drench
