#pragma once
// `drench view` and `drench run --view`: both are done by drench-view, a program beside this one. Only where it is
// built.

#include <filesystem>
#include <stdexcept>

namespace drench {

/// A window that cannot be had as it was asked for. One line.
struct ViewError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Becomes drench-view with these arguments, those after `view`. Throws ViewError where it cannot be started.
[[noreturn]] void become_viewer(char** arguments);

/// False, after a line on stderr, where no window can be opened.
bool viewer_can_open();

/// Starts a window that follows the run in this folder. It lives on when the run ends, and the run goes on without it.
void start_viewer(const std::filesystem::path& folder);

}  // namespace drench
