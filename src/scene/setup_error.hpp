#pragma once

#include <stdexcept>
#include <string>

namespace drench {

/// A scene that reads well but cannot be set up: a bad mesh, water outside the domain, too large for the memory.
struct SetupError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace drench
