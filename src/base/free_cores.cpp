#include "base/free_cores.hpp"

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <thread>
#include <vector>

namespace drench {
namespace {

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

int allowed_cores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
}

double share_of_core() {
  constexpr double probe = 0.03;  // s
  const double start = seconds(CLOCK_MONOTONIC), spent = seconds(CLOCK_THREAD_CPUTIME_ID);
  double now = start;
  while (now < start + probe) now = seconds(CLOCK_MONOTONIC);
  return (seconds(CLOCK_THREAD_CPUTIME_ID) - spent) / (now - start);
}

double free_cores() {
  const int cores = allowed_cores();
  std::vector<double> share(static_cast<std::size_t>(cores), 0.0);
  std::vector<std::thread> threads;
  for (double& own : share)
    threads.emplace_back([&own] { own = share_of_core(); });
  for (std::thread& t : threads) t.join();
  double sum = 0;
  for (const double own : share) sum += own;
  return sum;
}

int threads_for(double free, int cores) { return std::clamp(static_cast<int>(free + 0.25), 1, std::max(1, cores)); }

}  // namespace drench
