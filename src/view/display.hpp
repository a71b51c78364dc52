#pragma once
// Where pictures are drawn: VTK's windows need an X server, also those that nobody sees.

#include <sys/types.h>

namespace drench {

/// True when an X server answers at DISPLAY.
bool has_display();

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
