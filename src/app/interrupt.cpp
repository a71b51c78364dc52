#include "app/interrupt.hpp"

#include <csignal>

namespace drench {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void on_interrupt(int signal) {
  interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptGuard::InterruptGuard()
    : before_(std::signal(SIGINT, on_interrupt)), before_end_(std::signal(SIGTERM, on_interrupt)) {
  interrupted = 0;
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, before_);
  std::signal(SIGTERM, before_end_);
}

bool InterruptGuard::asked() { return interrupted != 0; }

}  // namespace drench
