#pragma once
// Ctrl-C, a batch system's notice and the end of a terminal, while a run goes on.

#include <array>

namespace drench {

/// While it lives, the first SIGINT, SIGTERM or SIGHUP is noted, and a second one ends the program at once. Signals
/// that the program was started to ignore stay ignored.
class InterruptGuard {
 public:
  /// `speaks_of_it`: answers a signal with a line on stderr.
  explicit InterruptGuard(bool speaks_of_it);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Whether somebody has asked for an orderly end.
  static bool asked();

 private:
  std::array<void (*)(int), 3> before_{};
};

}  // namespace drench
