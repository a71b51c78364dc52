#pragma once
// What a run over ranks tells at its end of the time that they spent on each other.

#include <algorithm>
#include <string>

#include "output/run_log.hpp"
#include "parallel/communicator.hpp"

namespace drench {

/// How even the liquid lay on the ranks.
struct RankBalance {
  double sum = 0, most = 1;  // of StepReport::imbalance
  std::int64_t cuts = 0;

  void add(const StepReport& report) {
    sum += report.imbalance;
    most = std::max(most, report.imbalance);
    cuts = report.cuts;
  }
};

/// Time by part, messages and balance, in lines; called by all ranks.
std::string rank_table(const Communicator& ranks, const RunTotals& totals, const RankBalance& balance);

}  // namespace drench
