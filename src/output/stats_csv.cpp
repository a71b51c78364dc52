#include "output/stats_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <stdexcept>

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

StatsCsv::StatsCsv(const std::filesystem::path& path, const std::vector<Stage>& stages, double quantum,
                   Quanta initial_total, std::int64_t after)
    : path_(path),
      stages_(stages),
      moving_cloth_(std::find(stages.begin(), stages.end(), Stage::cloth) != stages.end()),
      measures_(std::find(stages.begin(), stages.end(), Stage::measures) != stages.end()),
      quantum_(quantum),
      initial_total_(initial_total) {
  if (after >= 0 && std::filesystem::exists(path)) {
    const auto rows = rows_until(path, after);
    if (!rows) throw std::runtime_error(fmt::format("{}: has no row of step {}", path_.string(), after));
    if (rows->size() != std::filesystem::file_size(path)) write_atomically(path, *rows);
    out_.open(path, std::ios::app);
    if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
    return;
  }
  out_.open(path);
  out_ << "step,time,dt,particles,density_iterations,divergence_iterations,density_error,density_error_max,"
          "mass_fluid,mass_cloth,mass_drained,mass_supplied,mass_total,mass_error,saturation_max,kinetic_energy,"
          "divergence_error,diffusion_substeps,collisions,clamped,mass_float";
  if (moving_cloth_) out_ << ",cloth_iterations,cloth_residual";
  if (measures_) out_ << ",nearest_variance,close_share,wet_isotropy";
  out_ << ",ms_step";
  for (const Stage s : stages_) out_ << ",ms_" << name_of(s);
  out_ << std::endl;
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path_.string()));
}

void StatsCsv::write(const StepReport& r, const std::array<double, stage_count>& milliseconds,
                     double step_milliseconds) {
  const auto kg = [&](Quanta m) { return static_cast<double>(m) * quantum_; };
  fmt::memory_buffer row;
  auto end = std::back_inserter(row);
  fmt::format_to(end, "{},{:.10g},{:.10g},{},{},{},{:.6g},{:.6g},", r.step, r.time, r.dt, r.particles,
                 r.density_iterations, r.divergence_iterations, r.density_error, r.density_error_max);
  fmt::format_to(end, "{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.9g},{:.9g},", kg(r.mass_fluid),
                 kg(r.mass_cloth), kg(r.mass_drained), kg(r.mass_supplied), kg(r.mass_total()),
                 kg(r.mass_total() - initial_total_), r.saturation_max, r.kinetic_energy);
  fmt::format_to(end, "{:.6g},{},{},{},{:.17g}", r.divergence_error, r.diffusion_substeps, r.collisions, r.clamped,
                 r.mass_float);
  if (moving_cloth_) fmt::format_to(end, ",{},{:.6g}", r.cloth_iterations, r.cloth_residual);
  if (measures_) fmt::format_to(end, ",{:.6g},{:.6g},{:.6g}", r.nearest_variance, r.close_share, r.wet_isotropy);
  fmt::format_to(end, ",{:.4f}", step_milliseconds);
  for (const Stage s : stages_) fmt::format_to(end, ",{:.4f}", milliseconds[static_cast<std::size_t>(s)]);
  out_.write(row.data(), static_cast<std::streamsize>(row.size()));
  out_ << std::endl;  // flushed, so that the file can be followed
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written (disk full?)", path_.string()));
}

void StatsCsv::sync() const { sync_to_disk(path_); }

}  // namespace drench
