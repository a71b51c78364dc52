#pragma once
// The one error of scene loading.

#include <stdexcept>
#include <string>

namespace drench {

/// A scene that cannot be used. what() is exactly one line, `file:line:column: key.path: what is wrong; allowed: …`
/// (line and column from 1). `--set key.path=value` stands in place of file:line:column when the value came from there,
/// and only the file when it could not be read at all. Control characters are shown as \xNN.
struct SceneError : std::runtime_error {
  SceneError(const std::string& where, const std::string& message);
};

}  // namespace drench
