#include "app/interrupt.hpp"

#include <csignal>

#include "base/stop_request.hpp"

namespace drench {
namespace {

void on_interrupt(int signal) {
  request_stop();
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptGuard::InterruptGuard()
    : before_(std::signal(SIGINT, on_interrupt)), before_end_(std::signal(SIGTERM, on_interrupt)) {
  forget_stop_request();
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, before_);
  std::signal(SIGTERM, before_end_);
}

bool InterruptGuard::asked() { return stop_requested(); }

}  // namespace drench
