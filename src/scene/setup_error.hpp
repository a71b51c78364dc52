#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace drench {

/// A scene that reads well but cannot be set up: a bad mesh, water outside the domain, too large for the memory. `key` is
/// what in the scene is to blame, dotted as in `--set`; "" as long as nobody said.
struct SetupError : std::runtime_error {
  explicit SetupError(const std::string& what, std::string to_blame = "")
      : std::runtime_error(what), key(std::move(to_blame)) {}
  std::string key;
};

/// Calls f(); a SetupError that names no key gets this one.
template <class F>
decltype(auto) blaming(const std::string& key, F&& f) {
  try {
    return f();
  } catch (const SetupError& error) {
    throw SetupError(error.what(), error.key.empty() ? key : error.key);
  }
}

}  // namespace drench
