#pragma once

#include "view/options.hpp"

namespace drench {

/// Opens the viewer's window and returns when it is closed. Throws std::runtime_error.
void open_window(const ViewOptions& options);

}  // namespace drench
