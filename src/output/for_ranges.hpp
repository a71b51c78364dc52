#pragma once
// A loop over independent elements, shared out among a few threads of the output.

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace drench {

/// Calls f(i) for i < count, each i once. `threads` ≥ 1 take a range each; f writes nothing but what belongs to its i, and
/// does not throw.
template <class F>
void for_ranges(std::size_t count, int threads, F&& f) {
  const std::size_t parts = std::min(count, static_cast<std::size_t>(std::max(1, threads)));
  const auto part = [&](std::size_t p) {
    for (std::size_t i = count * p / parts; i < count * (p + 1) / parts; ++i) f(i);
  };
  std::vector<std::jthread> others;
  for (std::size_t p = 1; p < parts; ++p) others.emplace_back(part, p);
  if (parts > 0) part(0);
}

}  // namespace drench
