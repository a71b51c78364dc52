#include "view/display.hpp"

#include <X11/Xlib.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace drench {
namespace {

/// In the child: becomes Xvfb, which writes the number of its display to `out`. It ends with its parent.
[[noreturn]] void become_server(int out) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int nothing = open("/dev/null", O_RDWR);
  dup2(nothing, STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  dup2(nothing, STDERR_FILENO);
  const std::string number = std::to_string(out);
  execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp",
         static_cast<char*>(nullptr));
  _exit(127);
}

/// The number and a line's end, or "" where the server ended before.
std::string read_line(int in) {
  std::string line;
  char c = 0;
  while (read(in, &c, 1) == 1 && c != '\n') line += c;
  return line;
}

}  // namespace

bool has_display() {
  Display* display = XOpenDisplay(nullptr);
  if (display) XCloseDisplay(display);
  return display != nullptr;
}

void wait_for_event(Display* display, double seconds) {
  if (XPending(display) > 0) return;
  pollfd server{ConnectionNumber(display), POLLIN, 0};
  poll(&server, 1, seconds < 0 ? -1 : static_cast<int>(std::ceil(1000 * seconds)));
}

VirtualDisplay::VirtualDisplay() {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe for a virtual display");
  server_ = fork();
  if (server_ == 0) {
    close(ends[0]);
    become_server(ends[1]);
  }
  close(ends[1]);
  const std::string number = server_ > 0 ? read_line(ends[0]) : "";
  close(ends[0]);
  if (number.empty()) {
    if (server_ > 0) waitpid(server_, nullptr, 0);
    throw std::runtime_error("no display, and no Xvfb to draw without one: apt-get install xvfb");
  }
  setenv("DISPLAY", (":" + number).c_str(), 1);
}

VirtualDisplay::~VirtualDisplay() {
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace drench
