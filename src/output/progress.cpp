#include "output/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace drench {
namespace {

std::string duration_text(double seconds) {
  const std::int64_t s = std::llround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

}  // namespace

Progress::Progress(bool quiet, double start, double end, std::int64_t max_steps)
    : quiet_(quiet),
      terminal_(isatty(STDOUT_FILENO) == 1),
      start_(start),
      end_(end),
      max_steps_(max_steps),
      begin_(Clock::now()),
      last_(begin_) {}

void Progress::update(double time, std::int64_t step, std::int64_t steps_done, const StepReport& report,
                      double mass_error) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (std::chrono::duration<double>(now - last_).count() < (terminal_ ? 0.2 : 5.0)) return;
  last_ = now;
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  double done = end_ > start_ ? (time - start_) / (end_ - start_) : 1.0;
  if (max_steps_ > 0) done = std::max(done, static_cast<double>(steps_done) / static_cast<double>(max_steps_));
  const std::string left = done > 0 ? duration_text(elapsed * std::max(0.0, 1 - done) / done) : "?";
  const std::string line = fmt::format(
      "t {:.4f}/{:.4g} s  step {}  particles {}  iterations: divergence {}, density {}, cloth {}  mass error {:.3g} kg "
      " "
      "{:.1f} steps/s  remaining {}",
      time, end_, step, report.particles, report.divergence_iterations, report.density_iterations,
      report.cloth_iterations, mass_error, static_cast<double>(steps_done) / elapsed, left);
  if (terminal_)
    std::fputs(fmt::format("\r{}\x1b[K", line).c_str(), stdout);  // no exception where the terminal has gone
  else
    std::fputs((line + "\n").c_str(), stdout);
  line_open_ = terminal_;
  std::fflush(stdout);
}

void Progress::finish() {
  if (line_open_) std::fputs("\n", stdout);
  line_open_ = false;
  std::fflush(stdout);
}

}  // namespace drench
