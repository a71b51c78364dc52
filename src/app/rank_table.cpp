#include "app/rank_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <vector>

namespace drench {

std::string rank_table(const Communicator& ranks, const RunTotals& totals, const RankBalance& balance) {
  const Traffic own = ranks.traffic();
  double stages = 0;
  for (const double ms : totals.milliseconds()) stages += ms / 1000;
  const double parts[] = {stages - own.packing - own.exchanging - own.summing, own.packing, own.exchanging,
                          own.summing};
  const char* const names[] = {"compute", "pack", "exchange, wait", "sums, wait"};
  std::vector<double> most(std::begin(parts), std::end(parts));
  std::vector<std::int64_t> sums;  // µs and counts
  for (const double s : parts) sums.push_back(std::llround(1e6 * s));
  sums.insert(sums.end(), {own.sums, own.messages, own.bytes});
  ranks.all_reduce(sums, most);
  const double steps = std::max(1.0, static_cast<double>(totals.steps())), count = ranks.size();
  const auto mean = [&](std::size_t k) { return static_cast<double>(sums[k]) / count; };
  std::string text = fmt::format("{} ranks, mean and maximum\n", ranks.size());
  for (std::size_t k = 0; k < std::size(parts); ++k)
    text += fmt::format("{:<18}{:>10.3f} s {:>10.3f} ms/step, at most {:.3f} ms/step\n", names[k], 1e-6 * mean(k),
                        1e-3 * mean(k) / steps, 1e3 * most[k] / steps);
  text += fmt::format("per step and rank: {:.1f} sums, {:.1f} messages, {:.3f} MiB sent\n", mean(4) / steps,
                      mean(5) / steps, mean(6) / steps / (1 << 20));
  return text + fmt::format("imbalance {:.3f} on average, {:.3f} at most; the domain was divided again {} times\n",
                            balance.sum / steps, balance.most, balance.cuts);
}

}  // namespace drench
