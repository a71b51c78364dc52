#include "output/stats_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "output/text_file.hpp"

namespace drench {

std::optional<std::string> StatsCsv::rows_until(const std::filesystem::path& path, std::int64_t step) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::size_t end = text.find('\n');
  std::int64_t last = 0;
  while (end != std::string::npos && last < step) {
    const std::size_t next = text.find('\n', end + 1);
    if (next == std::string::npos) break;
    last = std::strtoll(text.c_str() + end + 1, nullptr, 10);
    if (last <= step) end = next;
  }
  if (end == std::string::npos || last != step) return std::nullopt;
  return text.substr(0, end + 1);
}

namespace {

/// "a,b,c" → a, b, c
std::vector<std::string> names_in(const std::string& header) {
  std::vector<std::string> names(1);
  for (const char c : header)
    if (c == ',')
      names.emplace_back();
    else
      names.back() += c;
  return names;
}

/// The columns under construction: a name, a format, and what stands there.
class Columns {
 public:
  /// `value` is a member of StepReport, or a function of one.
  template <class Value>
  void of_report(const std::string& name, const char* format, Value value) {
    of_row(name, format, [value](const StatsRow& row) { return std::invoke(value, row.report); });
  }
  template <class Value>
  void of_row(const std::string& name, const char* format, Value value) {
    all_.push_back({name, [format, value](const StatsRow& row) {
                      return fmt::format(fmt::runtime(format), std::invoke(value, row));
                    }});
  }
  std::vector<StatsColumn> take() { return std::move(all_); }

 private:
  std::vector<StatsColumn> all_;
};

using Report = StepReport;

void add_masses(Columns& columns, double quantum, Quanta initial_total) {
  const auto kilograms = [&](const char* name, auto quanta) {
    columns.of_report(name, "{:.17g}",
                      [=](const Report& r) { return static_cast<double>(std::invoke(quanta, r)) * quantum; });
  };
  kilograms("mass_fluid", &Report::mass_fluid);
  kilograms("mass_cloth", &Report::mass_cloth);
  kilograms("mass_drained", &Report::mass_drained);
  kilograms("mass_supplied", &Report::mass_supplied);
  kilograms("mass_total", &Report::mass_total);
  kilograms("mass_error", [=](const Report& r) { return r.mass_total() - initial_total; });
}

void add_solute(Columns& columns, const SoluteTotal& solute) {
  const auto kilograms = [&](const char* name, auto quanta) {
    columns.of_report(name, "{:.17g}",
                      [=](const Report& r) { return static_cast<double>(std::invoke(quanta, r)) * solute.quantum; });
  };
  kilograms("solute_fluid", &Report::solute_fluid);
  kilograms("solute_cloth", &Report::solute_cloth);
  kilograms("solute_drained", &Report::solute_drained);
  kilograms("solute_supplied", &Report::solute_supplied);
  kilograms("solute_deposited", &Report::solute_deposited);
  kilograms("solute_total", &Report::solute_total);
  kilograms("solute_error", [=](const Report& r) { return r.solute_total() - solute.initial; });
}

/// Columns of every scene. docs/tutorial/4_wetting.md reads the first of them by their numbers.
void add_common(Columns& columns, double quantum, Quanta initial_total) {
  columns.of_report("step", "{}", &Report::step);
  columns.of_report("time", "{:.10g}", &Report::time);
  columns.of_report("dt", "{:.10g}", &Report::dt);
  columns.of_report("particles", "{}", &Report::particles);
  columns.of_report("density_iterations", "{}", &Report::density_iterations);
  columns.of_report("divergence_iterations", "{}", &Report::divergence_iterations);
  columns.of_report("density_error", "{:.6g}", &Report::density_error);
  columns.of_report("density_error_max", "{:.6g}", &Report::density_error_max);
  add_masses(columns, quantum, initial_total);
  columns.of_report("saturation_max", "{:.9g}", &Report::saturation_max);
  columns.of_report("kinetic_energy", "{:.9g}", &Report::kinetic_energy);
  columns.of_report("divergence_error", "{:.6g}", &Report::divergence_error);
  columns.of_report("diffusion_substeps", "{}", &Report::diffusion_substeps);
  columns.of_report("collisions", "{}", &Report::collisions);
  columns.of_report("clamped", "{}", &Report::clamped);
  columns.of_report("mass_float", "{:.17g}", &Report::mass_float);
}

/// Columns of a stage, where it runs.
void add_of_stages(Columns& columns, const std::vector<Stage>& stages, double quantum) {
  const auto runs = [&](Stage stage) { return std::find(stages.begin(), stages.end(), stage) != stages.end(); };
  if (runs(Stage::cloth)) {
    columns.of_report("cloth_iterations", "{}", &Report::cloth_iterations);
    columns.of_report("cloth_residual", "{:.6g}", &Report::cloth_residual);
  }
  if (runs(Stage::porous_neighbors)) columns.of_report("error_saturation", "{:.6g}", &Report::saturation_error);
  if (runs(Stage::evaporation) || runs(Stage::drying))
    columns.of_report("mass_evaporated", "{:.17g}",
                      [=](const Report& r) { return static_cast<double>(r.mass_evaporated) * quantum; });
  if (runs(Stage::measures)) {
    columns.of_report("nearest_variance", "{:.6g}", &Report::nearest_variance);
    columns.of_report("close_share", "{:.6g}", &Report::close_share);
    columns.of_report("wet_isotropy", "{:.6g}", &Report::wet_isotropy);
  }
  if (runs(Stage::forces)) {
    columns.of_report("viscosity_stages", "{}", &Report::viscosity_stages);
    columns.of_report("fluid_speed", "{:.6g}", &Report::fluid_speed);
  }
  if (runs(Stage::micropolar)) columns.of_report("micropolar_stages", "{}", &Report::micropolar_stages);
  if (runs(Stage::cloth)) {
    columns.of_report("cloth_speed", "{:.6g}", &Report::cloth_speed);
    columns.of_report("cloth_stretch", "{:.6g}", &Report::cloth_stretch);
  }
  if (runs(Stage::self_collision)) {
    columns.of_report("cloth_contacts", "{}", &Report::cloth_contacts);
    columns.of_report("cloth_zone_nodes", "{}", &Report::cloth_zone_nodes);
  }
}

/// Columns of a porous cloth, entry k of StepReport::fabrics.
void add_of_fabric(Columns& columns, double quantum, std::size_t k, Index cloth) {
  const auto add = [&](const char* name, const char* format, auto number) {
    columns.of_report(fmt::format("{}_{}", name, cloth), format,
                      [=](const Report& r) { return k < r.fabrics.size() ? number(r.fabrics[k]) : 0; });
  };
  const auto kilograms = [&](const char* name, auto quanta) {
    add(name, "{:.12g}", [=](const FabricNumbers& f) { return static_cast<double>(std::invoke(quanta, f)) * quantum; });
  };
  kilograms("liquid", &FabricNumbers::liquid);
  kilograms("taken_front", &FabricNumbers::taken_front);
  kilograms("taken_back", &FabricNumbers::taken_back);
  kilograms("through", &FabricNumbers::through);
  kilograms("returned", &FabricNumbers::returned);
  add("wet_area", "{:.9g}", [](const FabricNumbers& f) { return f.wet_area; });
  add("wet_warp", "{:.9g}", [](const FabricNumbers& f) { return f.wet_warp; });
  add("wet_weft", "{:.9g}", [](const FabricNumbers& f) { return f.wet_weft; });
}

}  // namespace

StatsCsv::StatsCsv(const std::filesystem::path& path, const std::vector<Stage>& stages, double quantum,
                   Quanta initial_total, std::int64_t after, const StatsKinds& kinds)
    : path_(path) {
  Columns columns;
  add_common(columns, quantum, initial_total);
  add_of_stages(columns, stages, quantum);
  if (kinds.solute.quantum > 0) add_solute(columns, kinds.solute);
  if (std::find(stages.begin(), stages.end(), Stage::fabric) != stages.end())
    for (std::size_t k = 0; k < kinds.fabrics.size(); ++k) add_of_fabric(columns, quantum, k, kinds.fabrics[k]);
  if (kinds.by_error) {
    columns.of_report("error_density", "{:.6g}", &Report::density_found);
    columns.of_report("rejected", "{}", &Report::rejected);
  }
  columns.of_row("ms_step", "{:.4f}", [](const StatsRow& row) { return row.step_milliseconds; });
  for (const Stage s : stages)
    columns.of_row("ms_" + std::string(name_of(s)), "{:.4f}",
                   [s](const StatsRow& row) { return row.milliseconds[static_cast<std::size_t>(s)]; });
  const bool goes_on = after >= 0 && std::filesystem::exists(path);
  if (kinds.among_ranks || goes_on) {
    columns.of_row("ms_exchange", "{:.4f}", &StatsRow::exchange_milliseconds);
    columns.of_row("ms_sums", "{:.4f}", &StatsRow::sum_milliseconds);
    columns.of_report("imbalance", "{:.4g}", &Report::imbalance);
  }
  columns_ = columns.take();
  if (goes_on) {
    go_on(after);
    return;
  }
  out_.open(path);
  for (const StatsColumn& c : columns_) out_ << (&c == columns_.data() ? "" : ",") << c.name;
  out_ << std::endl;
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

void StatsCsv::go_on(std::int64_t after) {
  const auto rows = rows_until(path_, after);
  if (!rows) throw std::runtime_error(fmt::format("{}: has no row of step {}", path_.string(), after));
  std::vector<StatsColumn> kept;
  for (const std::string& name : names_in(rows->substr(0, rows->find('\n')))) {
    const auto same = [&](const StatsColumn& c) { return c.name == name; };
    const auto at = std::find_if(columns_.begin(), columns_.end(), same);
    if (at == columns_.end())
      throw std::runtime_error(fmt::format("{}: has an unknown column {}", path_.string(), name));
    kept.push_back(*at);
  }
  columns_ = std::move(kept);
  if (rows->size() != std::filesystem::file_size(path_)) write_atomically(path_, *rows);
  out_.open(path_, std::ios::app);
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

void StatsCsv::write(const StatsRow& row) {
  std::string line;
  for (const StatsColumn& c : columns_) line += (line.empty() ? "" : ",") + c.text(row);
  out_ << line << std::endl;  // flushed, so that the file can be followed
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written (disk full?)", path_.string()));
}

void StatsCsv::sync() const { sync_to_disk(path_); }

}  // namespace drench
