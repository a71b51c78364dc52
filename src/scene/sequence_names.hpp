#pragma once
// The names of files that are numbered, or alike.

#include <string>
#include <vector>

namespace drench {

struct SequenceNames {
  std::vector<std::string> names;
  std::string problem;  // empty: none; otherwise as the end of a message
};

/// Of "ball_{:04d}.obj": the numbered files that exist, from the lowest number on. Of "ball_*.obj": those that exist,
/// by the numbers in their names (2 before 10). Relative ones lie in `folder`. Any other text is itself a name. A
/// problem: a number is missing; with `*`, and nothing but numbers in its place, these may be 0, 5, 10, … too.
SequenceNames sequence_names(const std::string& pattern, const std::string& folder);

}  // namespace drench
