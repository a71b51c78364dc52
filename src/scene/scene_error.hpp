#pragma once
// The one error of scene loading.

#include <stdexcept>
#include <string>

namespace drench {

/// A scene that cannot be used.
///
/// what() is exactly one line, `file:line:column: key.path: what is wrong; allowed: …`, line and column from 1. For a
/// value of `--set key.path=value`, that text replaces `file:line:column`; for a file that cannot be read, the file
/// alone does. Control characters are shown in hexadecimal.
struct SceneError : std::runtime_error {
  /// @param where `file:line:column: key.path`, or less of it
  /// @param message the rest of the line
  SceneError(const std::string& where, const std::string& message);
};

}  // namespace drench
