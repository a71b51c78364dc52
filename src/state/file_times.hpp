#pragma once
// Between which files of a sequence a time lies.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace drench {

/// Points are (1 − part) first + part last.
struct FilePart {
  std::size_t first = 0, last = 0;
  double part = 0;  // 1, in [0, 1)
};

/// `times` (s) rise. Before the first and from the last on, `first` and `last` are the same file.
inline FilePart files_at(const std::vector<double>& times, double time) {
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (after == 0) return {};
  const std::size_t first = after - 1;
  if (after == times.size()) return {first, first, 0};
  return {first, after, (time - times[first]) / (times[after] - times[first])};
}

}  // namespace drench
