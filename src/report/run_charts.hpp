#pragma once
// Charts of columns of a run's tables, over time, of one run or of two.

#include <string>
#include <vector>

#include "report/sections.hpp"
#include "report/svg_chart.hpp"

namespace drench {

/// A column in a chart.
struct Curve {
  std::string column, label;
  int colour = 0;
};

/// A chart of these columns of `table`, where a run has them. A second run's curves are dashed; in a chart of one
/// column they have a colour of their own, and the curves' labels are A and B.
LineChart chart_of(const Runs& runs, const std::string& title, const std::string& y_label,
                   const std::vector<Curve>& curves, StatsTable RunRecord::*table = &RunRecord::stats);

/// <div> of figures side by side; "" for none.
std::string charts(const std::vector<std::string>& figures);

/// Which line is whose; "" for one run.
std::string line_key(const Runs& runs);

}  // namespace drench
