#pragma once
// The names of files that are numbered, or alike.

#include <string>
#include <vector>

namespace drench {

/// Of "ball_{:04d}.obj": those that exist of 0, 1, … or, without a 0, of 1, 2, … up to the first that is missing. Of
/// "ball_*.obj": those that exist, in the order of their names. Relative ones lie in `folder`. Any other text is itself
/// a name.
std::vector<std::string> sequence_names(const std::string& pattern, const std::string& folder);

}  // namespace drench
