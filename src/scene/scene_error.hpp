#pragma once
// The one error of scene loading.

#include <stdexcept>
#include <string>

namespace drench {

/// A scene that cannot be used.
///
/// what() is exactly one line, `file:line:column: key.path: what is wrong; allowed: …`, line and column from 1. When
/// the value came from `--set key.path=value`, that stands in place of `file:line:column`. When the file could not be
/// read at all, the file alone does. Control characters are shown in hexadecimal.
struct SceneError : std::runtime_error {
  /// @param where `file:line:column: key.path`, or less of it
  /// @param message the rest of the line
  SceneError(const std::string& where, const std::string& message);
};

}  // namespace drench
