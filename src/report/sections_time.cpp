// Where the time of a run goes.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/html.hpp"
#include "report/run_charts.hpp"
#include "report/sections.hpp"

namespace drench {
namespace {

constexpr std::size_t bins = 80;                 // of a run's time, in the stacked chart
constexpr std::size_t named = colour_count - 1;  // stages with a colour of their own

struct StageTime {
  std::string name;
  double sum = 0;  // ms
};

/// The longest first.
std::vector<StageTime> by_time(const RunRecord& run) {
  std::vector<StageTime> times;
  for (const std::string& name : run.stages()) times.push_back({name, summary_of(run.stats.column("ms_" + name)).sum});
  std::stable_sort(times.begin(), times.end(), [](const StageTime& a, const StageTime& b) { return a.sum > b.sum; });
  return times;
}

/// A stage has one colour in all charts of a page, by its place in the first run.
std::map<std::string, int> colours_of(const Runs& runs) {
  std::map<std::string, int> colours;
  for (const RunRecord& run : runs)
    for (const StageTime& s : by_time(run))
      if (colours.size() < named) colours.emplace(s.name, static_cast<int>(colours.size()));
  return colours;
}

struct Shares {
  std::vector<double> time;                          // s, middles of the bins that have steps
  std::map<std::string, std::vector<double>> share;  // %, by stage
};

Shares shares_of(const RunRecord& run) {
  const std::vector<double>& time = run.stats.column("time");
  const std::size_t rows = run.stats.rows(), count = std::min(bins, rows);
  Shares s;
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t from = b * rows / count, to = (b + 1) * rows / count;
    std::map<std::string, double> sums;
    double all = 0;
    for (const std::string& name : run.stages()) {
      const std::vector<double>& ms = run.stats.column("ms_" + name);
      for (std::size_t i = from; i < to; ++i) sums[name] += ms[i];
      all += sums[name];
    }
    if (!(all > 0)) continue;
    s.time.push_back(b == 0 ? 0 : b + 1 == count ? time.back() : (time[from] + time[to - 1]) / 2);
    for (const auto& [name, sum] : sums) s.share[name].push_back(100 * sum / all);
  }
  return s;
}

std::string stack(const Runs& runs, std::size_t k, const std::map<std::string, int>& colours) {
  const Shares shares = shares_of(runs[k]);
  StackChart chart{letter(runs, k) + "Share of a step", "time, s", "%", shares.time, {}, ""};
  Band rest{"others", std::vector<double>(shares.time.size(), 0), colour_count - 1};
  for (const StageTime& s : by_time(runs[k])) {
    const auto colour = colours.find(s.name);
    const auto share = shares.share.find(s.name);
    if (share == shares.share.end()) continue;
    if (colour != colours.end())
      chart.bands.push_back({s.name, share->second, colour->second});
    else
      std::transform(rest.share.begin(), rest.share.end(), share->second.begin(), rest.share.begin(), std::plus<>());
  }
  if (std::any_of(rest.share.begin(), rest.share.end(), [](double v) { return v > 0; })) chart.bands.push_back(rest);
  return figure(chart);
}

std::string stage_table(const RunRecord& run, const std::map<std::string, int>& colours, const std::string& id) {
  html::Table table{{"stage", "all steps, s", "per step, ms", "longest, ms", "share, %"}, {}, id};
  const std::vector<StageTime> times = by_time(run);
  double all = 0;
  for (const StageTime& s : times) all += s.sum;
  const auto rows = static_cast<double>(run.stats.rows());
  const auto row = [&](const std::string& heading, const std::string& column, double sum) {
    table.rows.push_back({html::markup(heading), html::number(sum / 1000, 4), html::number(sum / rows, 4),
                          html::number(summary_of(run.stats.column(column)).most, 4),
                          html::number(all > 0 ? 100 * sum / all : 0, 3)});
  };
  for (const StageTime& s : times) {
    const auto colour = colours.find(s.name);
    row(fmt::format("<span class=\"swatch f{}\"></span>{}", colour == colours.end() ? colour_count - 1 : colour->second,
                    html::escaped(s.name)),
        "ms_" + s.name, s.sum);
  }
  row("whole step", "ms_step", summary_of(run.stats.column("ms_step")).sum);
  return html::table(table);
}

bool on_device(const RunRecord& run) { return run.device_entry("backend").find("CUDA") != std::string::npos; }

}  // namespace

std::string stage_section(const Runs& runs) {
  const std::map<std::string, int> colours = colours_of(runs);
  if (colours.empty() || runs[0].stats.rows() == 0) return "";
  std::vector<std::string> figures;
  for (std::size_t k = 0; k < runs.size(); ++k)
    if (runs[k].stats.rows() > 0) figures.push_back(stack(runs, k, colours));
  figures.push_back(figure(chart_of(runs, "Wall time of a step", "ms", {{"ms_step", "step", 0}})));
  std::string out = charts(figures);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (runs[k].stats.rows() == 0) continue;
    out += run_heading(runs, k) + stage_table(runs[k], colours, k == 0 ? "stage-table" : "stage-table-b");
    if (on_device(runs[k]))
      out += html::note(
          "On a GPU the host does not wait for each stage, so stage times are exact only with --profile. The time of "
          "the "
          "whole step is always exact.");
  }
  return html::section("stages", "Time", out);
}

}  // namespace drench
