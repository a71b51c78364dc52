#include "app/interrupt.hpp"

#include <unistd.h>

#include <csignal>
#include <iterator>
#include <string_view>

#include "base/stop_request.hpp"

namespace drench {
namespace {

constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t speaks;

void on_interrupt(int signal) {
  request_stop();
  std::signal(signal, SIG_DFL);
  constexpr std::string_view answer =
      "\ndrench: stopping after this step and the frame that is being written; a second signal (Ctrl-C) ends the "
      "program at once\n";
  // write is one of the few functions that a signal handler may call.
  if (speaks && write(STDERR_FILENO, answer.data(), answer.size()) < 0) return;
}

}  // namespace

InterruptGuard::InterruptGuard(bool speaks_of_it) {
  speaks = speaks_of_it;
  forget_stop_request();
  for (std::size_t k = 0; k < std::size(signals); ++k) {
    before_[k] = std::signal(signals[k], on_interrupt);
    if (before_[k] == SIG_IGN) std::signal(signals[k], SIG_IGN);  // nohup, or a shell that runs it in the background
  }
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t k = 0; k < std::size(signals); ++k) std::signal(signals[k], before_[k]);
}

bool InterruptGuard::asked() { return stop_requested(); }

}  // namespace drench
