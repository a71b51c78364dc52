// What the numbers of a run say: masses, solves, energy, motion.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.hpp"
#include "report/run_charts.hpp"
#include "report/sections.hpp"

namespace drench {
namespace {

bool any_has(const Runs& runs, const std::string& column) {
  return std::any_of(runs.begin(), runs.end(),
                     [&](const RunRecord& r) { return r.stats.has(column) && r.stats.rows() > 0; });
}

bool all_zero(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return v == 0; });
}

double largest_magnitude(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most;
}

struct MassRow {
  const char *column, *name;
};
constexpr MassRow mass_rows[] = {{"mass_supplied", "supplied by emitters and fixed-saturation boundaries"},
                                 {"mass_fluid", "in the liquid"},
                                 {"mass_cloth", "in cloth"},
                                 {"mass_drained", "drained: left the domain or entered a drain"},
                                 {"mass_evaporated", "evaporated into the air"},
                                 {"mass_total", "total: liquid + cloth + drained + evaporated − supplied"},
                                 {"mass_error", "error: change of the total"},
                                 {"solute_fluid", "solute in the liquid"},
                                 {"solute_cloth", "solute on cloth"},
                                 {"solute_total", "solute in all: with what was drained and deposited − supplied"},
                                 {"solute_error", "error of the solute: change of the total"}};

std::string mass_table(const RunRecord& run, const std::string& id) {
  html::Table table{{"mass", "after the first step, kg", "at the end, kg", "largest, kg"}, {}, id};
  for (const MassRow& row : mass_rows) {
    const std::vector<double>& values = run.stats.column(row.column);
    if (values.empty()) continue;
    table.rows.push_back({html::text(row.name), html::number(values.front(), 9), html::number(values.back(), 9),
                          html::number(largest_magnitude(values), 9)});
  }
  return html::table(table);
}

/// Of the sum in floating point from the integers' sum, over the run.
std::string float_check(const RunRecord& run) {
  const auto &sum = run.stats.column("mass_float"), &fluid = run.stats.column("mass_fluid"),
             &cloth = run.stats.column("mass_cloth");
  if (sum.empty() || fluid.empty() || cloth.empty()) return "";
  double worst = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) worst = std::max(worst, std::abs(sum[i] - fluid[i] - cloth[i]));
  const double whole = largest_magnitude(sum);
  if (whole == 0) return "";
  return html::note(fmt::format(
      "Masses are counted in integer units, so an error of 0 is exact. The floating-point sum over particles and "
      "cloth differs from that count by at most {:.3g} kg, {:.2g} of the liquid.",
      worst, worst / whole));
}

struct Solve {
  const char *name, *iterations, *error, *tolerance_key, *cap_key;
  int colour;
};
constexpr Solve solves[] = {
    {"density", "density_iterations", "density_error", "fluid.solver.density_error", "fluid.solver.max_iterations", 0},
    {"divergence", "divergence_iterations", "divergence_error", "fluid.solver.divergence_error",
     "fluid.solver.max_iterations", 1},
    {"cloth", "cloth_iterations", "cloth_residual", "", "cloth_solver.max_iterations", 2}};

/// The cloth's residual is over its goal already, so it is to come below 1.
double tolerance(const RunRecord& run, const Solve& s) {
  if (!*s.tolerance_key) return 1;
  const double asked = run.number(s.tolerance_key).value_or(NAN);
  const yaml::Value* mode = run.find("time.mode");
  const bool shared = std::string_view(s.name) == "density" && mode && mode->text == "error";
  return shared ? std::min(asked, 0.5 * run.number("time.tolerance").value_or(NAN)) : asked;
}

/// Steps by run.log, which says it when the run ends; NaN before.
double not_converged(const RunRecord& run, const Solve& s) {
  if (run.history.ending == Ending::unfinished || run.history.ending == Ending::stopped) return NAN;
  const auto found = run.history.not_converged.find(s.name);
  return found == run.history.not_converged.end() ? 0 : static_cast<double>(found->second);
}

std::string solve_table(const RunRecord& run, const std::string& id) {
  html::Table table{{"solve", "iterations per step, mean", "median", "maximum", "limit per solve", "error, mean",
                     "worst", "tolerance", "solves not converged"},
                    {},
                    id};
  for (const Solve& s : solves) {
    const bool runs_here = run.stats.has(*s.tolerance_key ? "ms_pressure" : s.iterations);
    if (!runs_here || run.stats.rows() == 0) continue;
    const Summary n = summary_of(run.stats.column(s.iterations)), e = summary_of(run.stats.column(s.error));
    const double goal = tolerance(run, s);
    table.rows.push_back({html::text(s.name), html::number(n.mean, 4), html::whole(n.median), html::whole(n.most),
                          html::whole(run.number(s.cap_key).value_or(NAN)), html::number(e.mean, 3),
                          html::number(e.most, 3), html::number(goal, 3), html::whole(not_converged(run, s))});
  }
  return html::table(table);
}

std::string error_chart(const Runs& runs, const Solve& s, const std::string& title, const std::string& y_label) {
  if (!any_has(runs, s.error)) return "";
  std::vector<Curve> curves{{s.error, runs.size() > 1 ? "" : "error", s.colour}};
  LineChart chart = chart_of(runs, title, y_label, curves);
  if (std::all_of(chart.series.begin(), chart.series.end(), [](const Series& c) { return all_zero(*c.y); })) return "";
  chart.logarithmic = true;
  chart.levels.push_back({"tolerance", tolerance(runs[0], s), 7});
  return figure(chart);
}

std::string single(const Runs& runs, const char* title, const char* y_label, const char* column, const char* label,
                   int colour) {
  if (!any_has(runs, column)) return "";
  return figure(chart_of(runs, title, y_label, {{column, label, colour}}));
}

std::string solute_chart(const Runs& runs) {
  if (!any_has(runs, "solute_total")) return "";
  return figure(chart_of(runs, "Where the solute is", "kg",
                         {{"solute_fluid", "in the liquid", 0}, {"solute_cloth", "on cloth", 1}}));
}

}  // namespace

std::string mass_section(const Runs& runs) {
  if (!any_has(runs, "mass_fluid")) return "";
  std::vector<Curve> curves{{"mass_fluid", "in the liquid", 0}, {"mass_cloth", "in cloth", 1}};
  const auto moves = [&](const char* column) {
    return std::any_of(runs.begin(), runs.end(), [&](const RunRecord& r) { return !all_zero(r.stats.column(column)); });
  };
  if (moves("mass_supplied")) curves.push_back({"mass_supplied", "supplied", 2});
  if (moves("mass_evaporated")) curves.push_back({"mass_evaporated", "evaporated", 4});
  if (moves("mass_drained")) curves.push_back({"mass_drained", "drained", 3});
  if (!moves("mass_fluid") && !moves("mass_cloth") && !moves("mass_supplied") && !moves("mass_drained"))
    return html::section("mass", "Mass", html::paragraph("There is no liquid, neither in particles nor in cloth."));
  std::string out = line_key(runs);
  std::string error =
      moves("mass_error") ? single(runs, "Error of the mass budget", "kg", "mass_error", "error", 1) : "";
  out += charts({figure(chart_of(runs, "Where the liquid is", "kg", curves)),
                 moves("saturation_max") ? single(runs, "Saturation of the wettest node", "liquid / capacity, 1",
                                                  "saturation_max", "largest", 1)
                                         : "",
                 error, solute_chart(runs)});
  for (std::size_t k = 0; k < runs.size(); ++k)
    out += run_heading(runs, k) + mass_table(runs[k], k == 0 ? "mass-table" : "mass-table-b") + float_check(runs[k]);
  return html::section("mass", "Mass", out);
}

std::string solve_section(const Runs& runs) {
  std::vector<Curve> pressure;
  if (any_has(runs, "ms_pressure"))
    pressure = {{"density_iterations", "density", 0}, {"divergence_iterations", "divergence", 1}};
  const std::string figures =
      charts({pressure.empty() ? "" : figure(chart_of(runs, "Iterations of the pressure solves", "per step", pressure)),
              single(runs, "Iterations of the cloth solve", "per step", "cloth_iterations", "cloth", 2),
              error_chart(runs, solves[0], "Error of the density solve", "mean compression, 1"),
              error_chart(runs, solves[1], "Error of the divergence solve", "mean compression rate × Δt, 1"),
              error_chart(runs, solves[2], "Residual of the cloth solve", "over tolerance, 1")});
  if (figures.empty()) return "";
  std::string out = line_key(runs) + figures;
  for (std::size_t k = 0; k < runs.size(); ++k)
    out += run_heading(runs, k) + solve_table(runs[k], k == 0 ? "solve-table" : "solve-table-b");
  out += html::note("Errors of 0 are drawn at the lower edge of the chart.");
  if (!pressure.empty())
    out += html::note(
        "A step corrects only a fraction of the compression, fluid.solver.density_correction. The remaining "
        "compression "
        "may therefore exceed the tolerance although the solve converged. The last column, from run.log, counts the "
        "steps in which the solve did not converge.");
  if (any_has(runs, "cloth_iterations"))
    out += html::note("Cloth iterations include those within the density solve and may exceed the limit of one solve.");
  if (std::any_of(runs.begin(), runs.end(), [](const RunRecord& r) { return r.history.sessions > 1; }))
    out += html::note("For a resumed run, that column counts the steps since it was resumed.");
  return html::section("solves", "Solves", out);
}

namespace {

const Curve energy_parts[] = {{"liquid_kinetic", "liquid, kinetic", 0}, {"liquid_potential", "liquid, height", 5},
                              {"cloth_kinetic", "cloth, kinetic", 1},   {"cloth_potential", "cloth, height", 4},
                              {"stretch", "cloth, stretched", 2},       {"bend", "cloth, bent", 6},
                              {"body_kinetic", "bodies, kinetic", 3},   {"body_potential", "bodies, height", 7}};

/// Of one run: each part at its first frame and at its last.
void add_energy_rows(const Runs& runs, std::size_t k, html::Table& table) {
  const StatsTable& energy = runs[k].energy;
  const auto add = [&](const char* column, const char* name) {
    const std::vector<double>& values = energy.column(column);
    if (values.empty()) return;
    double rise = 0;
    for (std::size_t i = 1; i < values.size(); ++i) rise = std::max(rise, values[i] - values[i - 1]);
    table.rows.push_back({html::text(letter(runs, k) + name), html::number(values.front()), html::number(values.back()),
                          html::number(values.back() - values.front()), html::number(rise)});
  };
  for (const Curve& part : energy_parts) add(part.column.c_str(), part.label.c_str());
  add("total", "total");
}

std::string energy_balance(const Runs& runs) {
  if (std::none_of(runs.begin(), runs.end(), [](const RunRecord& r) { return r.energy.rows() > 0; })) return "";
  const auto chart = [&](const char* title, const std::vector<Curve>& curves) {
    return figure(chart_of(runs, title, "J", curves, &RunRecord::energy));
  };
  std::string out = charts({chart("Mechanical energy", {{"total", "total", 0}}),
                            chart("Its parts", std::vector<Curve>(std::begin(energy_parts), std::end(energy_parts)))});
  html::Table table{
      {"energy", "at the first frame, J", "at the last, J", "change, J", "largest rise between frames, J"},
      {},
      "energy-table"};
  for (std::size_t k = 0; k < runs.size(); ++k) add_energy_rows(runs, k, table);
  return out + html::table(table) +
         html::note(
             "Heights are measured from the lowest corner of the domain. Viscosity, friction, absorption, numerical "
             "losses and "
             "liquid that leaves reduce the total. Only emitters, fixed-saturation boundaries, pins, wind and moving "
             "bodies "
             "may increase it. A rise without any of these indicates an error. The energies of the liquid surface, of "
             "wet "
             "adhesion and of micropolar spins are not included.");
}

std::string kinetic_energy_of_each_step(const Runs& runs) {
  if (!any_has(runs, "kinetic_energy")) return "";
  html::Table table{
      {"kinetic energy", "after the first step, J", "at the end, J", "largest, J", "at t, s"}, {}, "kinetic-table"};
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const auto &energy = runs[k].stats.column("kinetic_energy"), &time = runs[k].stats.column("time");
    if (energy.empty()) continue;
    const auto most = std::max_element(energy.begin(), energy.end());
    table.rows.push_back({html::text(letter(runs, k) + "of liquid and moving cloth"), html::number(energy.front()),
                          html::number(energy.back()), html::number(*most),
                          html::number(time[static_cast<std::size_t>(most - energy.begin())])});
  }
  return charts({single(runs, "Kinetic energy, each step", "J", "kinetic_energy", "liquid, cloth", 0)}) +
         html::table(table);
}

}  // namespace

std::string energy_section(const Runs& runs) {
  const std::string out = energy_balance(runs) + kinetic_energy_of_each_step(runs);
  return out.empty() ? "" : html::section("energy", "Energy", out);
}

namespace {

std::string motion_table(const Runs& runs) {
  struct Row {
    const char *column, *name;
  };
  static constexpr Row rows[] = {{"dt", "length of a step, s"},
                                 {"particles", "particles"},
                                 {"fluid_speed", "fastest particle, m/s"},
                                 {"cloth_speed", "fastest cloth node, m/s"},
                                 {"cloth_stretch", "longest edge over its rest length"},
                                 {"cloth_contacts", "contacts of cloth with itself"},
                                 {"diffusion_substeps", "sub-steps of diffusion"},
                                 {"collisions", "particles stopped at cloth per step"},
                                 {"clamped", "particles pushed out of solids per step"}};
  html::Table table{{"quantity", "least", "mean", "most", "at the end"}, {}, "motion-table"};
  for (const Row& row : rows)
    for (std::size_t k = 0; k < runs.size(); ++k) {
      if (!runs[k].stats.has(row.column) || runs[k].stats.rows() == 0) continue;
      const Summary s = summary_of(runs[k].stats.column(row.column));
      table.rows.push_back({html::text(letter(runs, k) + row.name), html::number(s.least), html::number(s.mean),
                            html::number(s.most), html::number(s.last)});
    }
  return html::table(table);
}

}  // namespace

std::string motion_section(const Runs& runs) {
  std::vector<Curve> speeds;
  if (any_has(runs, "fluid_speed")) speeds.push_back({"fluid_speed", "particle", 0});
  if (any_has(runs, "cloth_speed")) speeds.push_back({"cloth_speed", "cloth node", 1});
  const bool liquid = any_has(runs, "ms_pressure");
  const std::string body =
      charts({speeds.empty() ? "" : figure(chart_of(runs, "Fastest", "m/s", speeds)),
              single(runs, "Stretch of the cloth", "length / rest length, 1", "cloth_stretch", "longest edge", 1),
              single(runs, "Length of a step", "s", "dt", "Δt", 3),
              liquid ? single(runs, "Particles", "number", "particles", "liquid", 0) : ""}) +
      motion_table(runs);
  return runs.empty() || body.empty() ? "" : html::section("motion", "Motion", line_key(runs) + body);
}

}  // namespace drench
