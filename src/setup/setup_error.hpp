#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace drench {

/// A scene that reads well but cannot be set up: a bad mesh, water outside the domain, too large for the memory.
struct SetupError : std::runtime_error {
  /// @param what one line
  /// @param to_blame the member `key`
  explicit SetupError(const std::string& what, std::string to_blame = "")
      : std::runtime_error(what), key(std::move(to_blame)) {}
  std::string key;  ///< of the scene, to blame; dotted as in `--set`, "" as long as nobody said
};

/// Calls `f` and returns its result. A SetupError that leaves it without a key gets this one.
template <class F>
decltype(auto) blaming(const std::string& key, F&& f) {
  try {
    return f();
  } catch (const SetupError& error) {
    throw SetupError(error.what(), error.key.empty() ? key : error.key);
  }
}

}  // namespace drench
