#pragma once
// A loop over independent elements, shared out among a few threads.

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace drench {

/// Calls f(begin, end) for ranges that cover [0, count), each in a thread of its own; at most `threads` ≥ 1 of them. f
/// writes nothing but what belongs to its range, and does not throw.
template <class F>
void for_parts(std::size_t count, int threads, F&& f) {
  const std::size_t parts = std::min(count, static_cast<std::size_t>(std::max(1, threads)));
  const auto part = [&](std::size_t p) { f(count * p / parts, count * (p + 1) / parts); };
  std::vector<std::jthread> others;
  for (std::size_t p = 1; p < parts; ++p) others.emplace_back(part, p);
  if (parts > 0) part(0);
}

/// The same with f(i) for each i.
template <class F>
void for_ranges(std::size_t count, int threads, F&& f) {
  for_parts(count, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

}  // namespace drench
