#pragma once
// Ctrl-C and a batch system's notice, while a run goes on.

namespace drench {

/// While it lives, the first SIGINT or SIGTERM is noted, and a second one ends the program at once.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Whether somebody has asked for an orderly end.
  static bool asked();

 private:
  void (*before_)(int);
  void (*before_end_)(int);
};

}  // namespace drench
