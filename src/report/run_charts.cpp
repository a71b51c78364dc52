#include "report/run_charts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/html.hpp"

namespace drench {

LineChart chart_of(const Runs& runs, const std::string& title, const std::string& y_label,
                   const std::vector<Curve>& curves, StatsTable RunRecord::*table) {
  LineChart chart{title, "time, s", y_label, {}, {}, false, ""};
  const bool by_run = curves.size() == 1 && runs.size() > 1;
  for (std::size_t k = 0; k < runs.size(); ++k)
    for (const Curve& c : curves) {
      const StatsTable& stats = runs[k].*table;
      if (!stats.has(c.column) || stats.rows() == 0) continue;
      const std::string label = by_run ? (k == 0 ? "A" : "B") : k == 0 ? c.label : "";
      chart.series.push_back(
          {label, &stats.column("time"), &stats.column(c.column), by_run ? static_cast<int>(k) : c.colour, k > 0});
    }
  return chart;
}

std::string charts(const std::vector<std::string>& figures) {
  std::string all;
  for (const std::string& f : figures) all += f;
  return all.empty() ? "" : "<div class=\"charts\">\n" + all + "</div>\n";
}

std::string line_key(const Runs& runs) {
  if (runs.size() < 2) return "";
  return fmt::format("<p class=\"note\"><span class=\"key\"></span>A, {}<br><span class=\"key b\"></span>B, {}</p>\n",
                     html::escaped(runs[0].folder.string()), html::escaped(runs[1].folder.string()));
}

std::string letter(const Runs& runs, std::size_t run) { return runs.size() < 2 ? "" : run == 0 ? "A: " : "B: "; }

std::string run_heading(const Runs& runs, std::size_t run) {
  return runs.size() < 2 ? ""
                         : fmt::format("<h3>{}{}</h3>\n", letter(runs, run), html::escaped(runs[run].folder.string()));
}

}  // namespace drench
