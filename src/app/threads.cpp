#include "app/threads.hpp"

#include <fmt/format.h>
#include <sys/auxv.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/free_cores.hpp"
#include "pipeline/runtime.hpp"

namespace drench {
namespace {

constexpr const char* watched =
    "DRENCH_WATCHES_THREADS";  // how many threads begin, where the choice was the program's own

/// False if the dynamic loader runs the program as its argument, as in a pack: /proc/self/exe is the loader then.
bool can_start_anew() { return getauxval(AT_BASE) != 0; }

}  // namespace

void settle_threads(char** argv, int asked) {
  if (std::getenv("OMP_WAIT_POLICY") != nullptr || std::getenv("GOMP_SPINCOUNT") != nullptr || !can_start_anew())
    return;
  const int cores = std::min(allowed_cores(), most_threads);
  if (asked <= 0)
    if (std::getenv("OMP_NUM_THREADS") != nullptr) asked = host_threads();
  if (cores == 1 || asked == 1) return;
  int free = 0;
  // A program that has just ended may have had a core for a part of the first look.
  for (int look = 0; look < 3 && free < cores; ++look) free = std::max(free, threads_for(free_cores(), cores));
  const int threads = asked > 0 ? asked : cores;
  setenv("OMP_NUM_THREADS", std::to_string(threads).c_str(), 1);
  const bool active = asked <= free;
  setenv("OMP_WAIT_POLICY", active ? "active" : "passive", 1);
  // Some milliseconds, then they sleep: what one thread does alone may take long, and its core may be another
  // program's.
  if (active) setenv("GOMP_SPINCOUNT", "200000", 1);
  setenv(watched, std::to_string(asked > 0 ? asked : free).c_str(), 1);
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

ThreadWatch::ThreadWatch() : all_(loop_threads()), threads_(all_), begin_(seconds_now()), pause_(seldom) {
  const char* begin = std::getenv(watched);
  if (begin == nullptr) all_ = threads_ = 1;
  if (all_ == 1) return;
  threads_ = std::clamp(std::atoi(begin), 1, all_);
  share_loops(threads_);
  interrupted_ = interruptions();
  next_ = begin_ + often;
}

std::string ThreadWatch::waiting() const {
  if (threads_ == all_) return "";
  return fmt::format("other programs use {} of {} cores: running with {} {} until they end", all_ - threads_, all_,
                     threads_, threads_ == 1 ? "thread" : "threads");
}

void ThreadWatch::look() {
  if (all_ == 1) return;
  if (const double now = seconds_now(); now >= next_) judge(now);
}

/// The kernel's accounts tell of a free core at no cost. A program that would give way to us shows only where threads
/// spin.
int ThreadWatch::threads_with_cores(double now) {
  const std::optional<double> busy = others_.busy_cores();
  const int threads = busy ? threads_for(all_ - *busy, all_) : 1;
  if (threads == all_ || now < next_probe_) return threads;
  const int probed = std::max(threads, threads_for(loop_cores(), all_));
  pause_ = probed == threads_ ? std::min(1.5 * pause_, most_seldom) : seldom;
  next_probe_ = seconds_now() + pause_;
  return probed;
}

void ThreadWatch::judge(double now) {
  const auto interrupted = static_cast<double>(interruptions() - interrupted_);
  if (threads_ < all_ || interrupted > most_interrupted * (now - begin_)) {
    threads_ = threads_with_cores(now);
    share_loops(threads_);
  } else {
    others_.busy_cores();  // a look begins where the last one ended
  }
  begin_ = seconds_now();
  interrupted_ = interruptions();
  next_ = begin_ + (threads_ == all_ ? often : seldom);
}

}  // namespace drench
