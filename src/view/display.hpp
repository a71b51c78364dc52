#pragma once
// Where pictures are drawn: VTK's windows need an X server, also those that nobody sees.

#include <sys/types.h>

using Display = struct _XDisplay;  // Xlib's

namespace drench {

/// True when an X server answers at DISPLAY.
bool has_display();

/// Sleeps until the server has an event for this connection, at most so many seconds; without end where they are
/// negative.
void wait_for_event(Display* display, double seconds);

/// An Xvfb of one's own, at DISPLAY while this lives.
class VirtualDisplay {
 public:
  /// Throws std::runtime_error where Xvfb is not installed or does not start.
  VirtualDisplay();
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

 private:
  pid_t server_;
};

}  // namespace drench
