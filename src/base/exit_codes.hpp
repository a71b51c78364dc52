#pragma once

namespace drench {

inline constexpr int exit_done = 0, exit_failed = 1, exit_usage = 2, exit_interrupted = 130;

}  // namespace drench
