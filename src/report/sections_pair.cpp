// Two runs in one table, and their scenes' differences.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.hpp"
#include "report/sections.hpp"
#include "scene/scene_difference.hpp"

namespace drench {
namespace {

/// "+3 %", or "× 12" where percents would have too many digits.
std::string relative(double a, double b) {
  if (a == b) return "equal";
  if (!std::isfinite(a) || !std::isfinite(b) || a == 0) return "–";
  if (b / a > 10) return fmt::format("× {:.3g}", b / a);
  return fmt::format("{:+.3g} %", 100 * (b - a) / std::abs(a));
}

std::vector<html::Cell> difference_row(const std::string& name, double a, double b) {
  const std::string change = a == b ? "0" : std::isfinite(b - a) ? fmt::format("{:+.4g}", b - a) : "–";
  return {html::text(name), html::number(a, 7), html::number(b, 7), {change, true}, {relative(a, b), true}};
}

/// The number of the last row that is not later; time ascends. `rows` of it are not 0.
std::size_t row_at(const StatsTable& stats, double time) {
  const auto& times = stats.column("time");
  const auto after = std::upper_bound(times.begin(), times.end(), time * (1 + 1e-9) + 1e-12);
  return after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin()) - 1;
}

constexpr std::size_t most_keys = 300;  // of the scenes' differences

struct Quantity {
  const char *column, *name;
};

/// States at the last time that both runs have come to.
std::string states(const RunRecord& a, const RunRecord& b) {
  static constexpr Quantity quantities[] = {{"particles", "particles"},
                                            {"mass_fluid", "liquid, kg"},
                                            {"mass_cloth", "in cloth, kg"},
                                            {"mass_drained", "drained, kg"},
                                            {"mass_evaporated", "evaporated, kg"},
                                            {"mass_supplied", "supplied, kg"},
                                            {"saturation_max", "largest saturation"},
                                            {"kinetic_energy", "kinetic energy, J"},
                                            {"fluid_speed", "fastest particle, m/s"},
                                            {"cloth_speed", "fastest cloth node, m/s"},
                                            {"cloth_stretch", "stretch of the cloth"}};
  const double time = std::min(a.stats.column("time").back(), b.stats.column("time").back());
  html::Table table{
      {fmt::format("at t = {:.6g} s", time), "A", "B", "B − A", "relative to A"}, {}, "state-differences"};
  const std::size_t in_a = row_at(a.stats, time), in_b = row_at(b.stats, time);
  for (const Quantity& q : quantities)
    if (a.stats.has(q.column) && b.stats.has(q.column))
      table.rows.push_back(difference_row(q.name, a.stats.column(q.column)[in_a], b.stats.column(q.column)[in_b]));
  return html::table(table) + html::note("Rows are those of the last step up to that time in each run.");
}

std::string whole_runs(const RunRecord& a, const RunRecord& b) {
  html::Table table{{"over the whole run", "A", "B", "B − A", "relative to A"}, {}, "run-differences"};
  const auto row = [&](const std::string& name, const std::string& column, auto value) {
    if (a.stats.has(column) && b.stats.has(column))
      table.rows.push_back(
          difference_row(name, value(summary_of(a.stats.column(column))), value(summary_of(b.stats.column(column)))));
  };
  const auto last = [](const Summary& s) { return s.last; };
  const auto mean = [](const Summary& s) { return s.mean; };
  const auto most = [](const Summary& s) { return s.most; };
  row("simulated time, s", "time", last);
  row("steps", "step", last);
  row("wall time of the steps, s", "ms_step", [](const Summary& s) { return s.sum / 1000; });
  row("wall time per step, ms", "ms_step", mean);
  row("mean length of a step, s", "dt", mean);
  row("density iterations per step", "density_iterations", mean);
  row("divergence iterations per step", "divergence_iterations", mean);
  row("cloth iterations per step", "cloth_iterations", mean);
  row("worst density error", "density_error", most);
  row("worst divergence error", "divergence_error", most);
  row("worst cloth residual", "cloth_residual", most);
  row("largest kinetic energy, J", "kinetic_energy", most);
  row("largest stretch of the cloth", "cloth_stretch", most);
  return html::table(table);
}

std::string facts(const RunRecord& a, const RunRecord& b) {
  html::Table table{{"program and machine", "A", "B"}, {}, "fact-differences"};
  const auto row = [&](const std::string& name, const std::string& x, const std::string& y) {
    if (x != y) table.rows.push_back({html::text(name), html::text(x), html::text(y)});
  };
  row("program", a.version, b.version);
  row("commit", a.commit, b.commit);
  row("precision", a.precision, b.precision);
  row("solver", a.backend, b.backend);
  for (const char* key : {"backend", "device", "threads", "Kokkos"}) row(key, a.device_entry(key), b.device_entry(key));
  row("peak memory of the arrays", a.history.memory, b.history.memory);
  return html::table(table);
}

html::Cell value_cell(const std::optional<std::string>& value) {
  constexpr std::size_t longest = 300;
  if (!value) return html::text("–");
  return html::text(value->size() <= longest ? *value : value->substr(0, longest) + " …");
}

std::string scenes(const RunRecord& a, const RunRecord& b) {
  html::Table table{{"key", "A", "B"}, {}, "scene-differences"};
  const auto differences = scene_differences(a.scene_text, b.scene_text, {});
  const std::size_t shown = std::min(differences.size(), most_keys);
  for (std::size_t k = 0; k < shown; ++k) {
    const KeyDifference& d = differences[k];
    table.rows.push_back({html::text(d.key), value_cell(d.before), value_cell(d.now)});
  }
  const std::string heading = "<h3>Scenes</h3>\n";
  if (differences.empty()) return heading + html::paragraph("The resolved scenes are equal.");
  const std::string rest =
      shown == differences.size() ? "" : html::note(fmt::format("The first {} of {} keys.", shown, differences.size()));
  return heading + html::table(table) + rest;
}

}  // namespace

std::string difference_section(const Runs& runs) {
  if (runs.size() < 2) return "";
  std::string out;
  if (runs[0].stats.rows() > 0 && runs[1].stats.rows() > 0)
    out = states(runs[0], runs[1]) + whole_runs(runs[0], runs[1]);
  else
    out = html::paragraph("One of the runs has no completed step, so only the scenes are compared.");
  return html::section("differences", "Differences", out + facts(runs[0], runs[1]) + scenes(runs[0], runs[1]));
}

}  // namespace drench
