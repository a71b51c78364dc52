#include "app/threads.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/free_cores.hpp"
#include "pipeline/runtime.hpp"

namespace drench {
namespace {

constexpr const char* watched = "DRENCH_WATCHES_THREADS";  // set where the choice of threads was the program's own

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
  const bool active = threads <= threads_for(free, cores);
  setenv("OMP_WAIT_POLICY", active ? "active" : "passive", 1);
  // Some milliseconds, then they sleep: what one thread does alone may take long, and its core may be another program's.
  if (active) setenv("GOMP_SPINCOUNT", "200000", 1);
  setenv(watched, "1", 1);
  std::fflush(nullptr);
  execv("/proc/self/exe", argv);
}

namespace {

constexpr double often = 0.2, seldom = 1, most_seldom = 16;  // s, between two looks
constexpr double most_interrupted = 40;                      // a second, of a thread that has its core

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
long interruptions() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return use.ru_nivcsw;
}

}  // namespace

ThreadWatch::ThreadWatch()
    : all_(std::getenv(watched) != nullptr ? loop_threads() : 1), threads_(all_), pause_(seldom), interrupted_(interruptions()) {
  begin_ = seconds_now();
  next_ = begin_ + often;
}

void ThreadWatch::look() {
  if (all_ == 1) return;
  if (const double now = seconds_now(); now >= next_) judge(now);
}

void ThreadWatch::judge(double now) {
  const auto interrupted = static_cast<double>(interruptions() - interrupted_);
  if (threads_ < all_ || interrupted > most_interrupted * (now - begin_)) {
    const int threads = threads_for(loop_cores(), all_);
    pause_ = threads == threads_ ? std::min(1.5 * pause_, most_seldom) : seldom;
    threads_ = threads;
    share_loops(threads_);
  }
  begin_ = seconds_now();
  interrupted_ = interruptions();
  next_ = begin_ + (threads_ == all_ ? often : pause_);
}

}  // namespace drench
