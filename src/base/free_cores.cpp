#include "base/free_cores.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace drench {
namespace {

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU time that the kernel has given to anyone on our cores, s; negative where it does not tell.
double machine_seconds() {
  cpu_set_t set;
  std::ifstream file("/proc/stat");
  if (!file || sched_getaffinity(0, sizeof(set), &set) != 0) return -1;
  double ticks = 0;
  int found = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string name;
    double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, interrupts = 0, soft = 0, stolen = 0;
    if (!(in >> name >> user >> nice >> system >> idle >> waiting >> interrupts >> soft >> stolen)) continue;
    int core = -1;
    if (std::sscanf(name.c_str(), "cpu%d", &core) != 1 || core >= CPU_SETSIZE || !CPU_ISSET(core, &set)) continue;
    ticks += user + nice + system + interrupts + soft + stolen;
    ++found;
  }
  return found > 0 ? ticks / static_cast<double>(sysconf(_SC_CLK_TCK)) : -1;
}

double own_seconds() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(use.ru_utime) + of(use.ru_stime);
}

}  // namespace

double quota_cores(const char* cpu_max) {
  double quota = 0, period = 0;
  return std::sscanf(cpu_max, "%lf %lf", &quota, &period) == 2 && quota > 0 && period > 0 ? quota / period : 0;
}

namespace {

/// Ranks of a run on this host, by the environment that mpirun gives.
int ranks_here() {
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"})
    if (const char* value = std::getenv(name)) return std::max(1, std::atoi(value));
  return 1;
}

}  // namespace

int allowed_cores() {
  cpu_set_t set;
  int cores = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  // Ranks that are not bound to cores of their own share them all.
  if (const int ranks = ranks_here(); ranks > 1 && cores == sysconf(_SC_NPROCESSORS_ONLN))
    cores = std::max(1, cores / ranks);
  std::ifstream file("/sys/fs/cgroup/cpu.max");
  std::string limit;
  std::getline(file, limit);
  const double quota = quota_cores(limit.c_str());
  return quota > 0 ? std::clamp(static_cast<int>(std::ceil(quota)), 1, cores) : cores;
}

int host_threads() {
  const char* given = std::getenv("OMP_NUM_THREADS");
  const int asked = given == nullptr ? 0 : std::atoi(given);
  return std::min(asked > 0 ? asked : allowed_cores(), most_threads);
}

OtherPrograms::OtherPrograms() : others_(machine_seconds()), now_(seconds(CLOCK_MONOTONIC)) {
  if (others_ >= 0) others_ -= own_seconds();
}

std::optional<double> OtherPrograms::busy_cores() {
  const double machine = machine_seconds();
  if (machine < 0) return {};
  const double others = machine - own_seconds(), now = seconds(CLOCK_MONOTONIC);
  const double cores = (others - others_) / (now - now_);
  others_ = others;
  now_ = now;
  return std::max(0.0, cores);
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
  for (double& own : share) threads.emplace_back([&own] { own = share_of_core(); });
  for (std::thread& t : threads) t.join();
  double sum = 0;
  for (const double own : share) sum += own;
  return sum;
}

int threads_for(double free, int cores) { return std::clamp(static_cast<int>(free + 0.25), 1, std::max(1, cores)); }

}  // namespace drench
