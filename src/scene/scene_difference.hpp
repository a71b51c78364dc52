#pragma once
// The difference between two resolved scenes, key by key.

#include <optional>
#include <string>
#include <vector>

namespace drench {

/// Keys that a run may be resumed with other values of: when it ends and what it writes. (Steps end at frames.)
inline const std::vector<std::string> resumable_keys{"time.end", "output.every", "output.checkpoint_every",
                                                     "output.report"};

/// A key that two scenes have with other values, or that only one of them has.
struct KeyDifference {
  std::string key;                         // dotted: "fluid.spacing"
  std::optional<std::string> before, now;  // as they stand there; none where the key is not
};

/// All keys in which two texts of to_yaml differ but for `allowed` and for where mesh files lie: those of `before` in
/// its order, then those that only `now` has.
std::vector<KeyDifference> scene_differences(const std::string& before, const std::string& now,
                                             const std::vector<std::string>& allowed);

/// "fluid.spacing was 0.01, is 0.02" for the first key, in the scene's order, in which two texts of to_yaml differ;
/// none when they are equal but for `allowed` and for where mesh files lie.
std::optional<std::string> scene_difference(const std::string& before, const std::string& now,
                                            const std::vector<std::string>& allowed);

}  // namespace drench
