// Independent runs, a step of each at a time.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <stdexcept>
#include <thread>

#include "drench/drench.hpp"

namespace drench {
namespace {

Stepped stepped(Simulation& run, double longest) {
  try {
    return {run.step(longest), nullptr};
  } catch (...) {
    return {{}, std::current_exception()};
  }
}

void require_valid(const std::vector<Simulation*>& runs, const std::vector<double>& longest) {
  if (longest.size() != runs.size())
    throw std::invalid_argument(
        fmt::format("step_together: {} runs have {} longest steps", runs.size(), longest.size()));
  for (const double l : longest)
    if (!(l > 0)) throw std::invalid_argument("step_together: a step has to be longer than 0 s");
  if (std::set<const Simulation*>(runs.begin(), runs.end()).size() != runs.size())
    throw std::invalid_argument("step_together: a run is named twice");
}

}  // namespace

std::vector<Stepped> step_together(const std::vector<Simulation*>& runs, const std::vector<double>& longest,
                                   int threads) {
  require_valid(runs, longest);
  std::vector<Stepped> results(runs.size());
  const int workers = std::min(threads > 0 ? threads : runs_at_a_time(), static_cast<int>(runs.size()));
  if (workers <= 1) {
    for (std::size_t k = 0; k < runs.size(); ++k) results[k] = stepped(*runs[k], longest[k]);
    return results;
  }
  std::atomic<std::size_t> next{0};
  const auto work = [&, shared = shared_loops()] {
    const OwnLoops loops(shared / workers);
    for (std::size_t k = next++; k < runs.size(); k = next++) results[k] = stepped(*runs[k], longest[k]);
  };
  {
    std::vector<std::jthread> others;  // end with the block
    for (int t = 1; t < workers; ++t) others.emplace_back(work);
    work();
  }
  return results;
}

}  // namespace drench
