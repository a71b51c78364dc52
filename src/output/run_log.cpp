#include "output/run_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <sstream>
#include <stdexcept>

namespace drench {

namespace {

/// What of a density solve is far from its goal beside the compression that is its error.
std::string cloth_in_solve(double residual) {
  return residual > 1 ? fmt::format("; the residual of the coupled cloth is {:.3g} times its tolerance", residual) : "";
}

}  // namespace

RunLog::RunLog(const std::filesystem::path& path, bool append) : out_(path, append ? std::ios::app : std::ios::out) {
  if (!out_) throw std::runtime_error(fmt::format("{}: cannot be written", path.string()));
}

void RunLog::write(const std::string& text) {
  if (!out_.is_open()) return;
  const auto stamp = fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::localtime(std::time(nullptr)));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out_ << stamp << "  " << line << '\n';
  out_.flush();
}

std::string RunTotals::add(std::int64_t step, double time, const StepReport& r,
                           const std::array<double, stage_count>& milliseconds) {
  ++steps_;
  particles_ = r.particles;
  clamped_ += r.clamped;
  density_.add(std::max(r.density_error, r.density_found));
  cloth_.add(r.cloth_residual);
  saturation_.add(r.saturation_error);
  for (std::size_t i = 0; i < milliseconds_.size(); ++i) milliseconds_[i] += milliseconds[i];
  const std::array<bool, 3> converged{r.divergence_converged, r.density_converged, r.cloth_converged};
  const std::array<double, 3> errors{r.divergence_error, r.density_error, r.cloth_residual};
  const std::array<int, 3> iterations{r.divergence_iterations, r.density_iterations, r.cloth_iterations};
  std::string said;
  for (std::size_t i = 0; i < solvers_.size(); ++i) {
    if (converged[i] || (i == 1 && errors[1] == 0 && !converged[2])) continue;  // then the cloth's own line says it
    Solver& s = solvers_[i];
    const double cloth = i == 1 ? r.cloth_residual : 0;
    if (s.failures++ == 0) {
      s.first_step = step;
      said += fmt::format("warning: step {} (t = {:.6g} s): the {} did not converge in {} iterations, error {:.3g}{}\n",
                          step, time, s.name, iterations[i], errors[i], cloth_in_solve(cloth));
    }
    s.last_step = step;
    s.worst_cloth = std::max(s.worst_cloth, cloth);
    s.worst = std::max(s.worst, errors[i]);
  }
  if (r.tunnelled > 0 && tunnelled_ == 0)
    said += fmt::format(
        "warning: step {} (t = {:.6g} s): {} particle{} passed through intact cloth, the first with id {}\n", step,
        time, r.tunnelled, r.tunnelled == 1 ? "" : "s", r.lowest_tunnelled);
  tunnelled_ += r.tunnelled;
  if (r.cloth_stretch > most_stretch_ && !(stretch_ > most_stretch_))
    said += fmt::format(
        "warning: step {} (t = {:.6g} s): cloth is stretched to {:.2f} times its length; beyond {:.2f} liquid passes "
        "between its quadrature points: use a stiffer cloth (stretch, strain_limit) or a smaller sample_spacing\n",
        step, time, r.cloth_stretch, most_stretch_);
  stretch_ = std::max(stretch_, r.cloth_stretch);
  if (r.escaped.count > 0 && escaped_ == 0)
    said += fmt::format(
        "warning: step {} (t = {:.6g} s): {} particles left the domain at once, more than a quarter of "
        "all: ids {}\n",
        step, time, r.escaped.count, r.escaped.names());
  escaped_ += r.escaped.count;
  return said;
}

std::string RunTotals::warnings() const {
  std::string text;
  for (const Solver& s : solvers_)
    if (s.failures > 0)
      text += fmt::format("the {} did not converge in {} of {} steps ({} to {}), worst error {:.3g}{}\n", s.name,
                          s.failures, steps_, s.first_step, s.last_step, s.worst, cloth_in_solve(s.worst_cloth));
  if (tunnelled_ > 0) text += fmt::format("particles passed through intact cloth {} times\n", tunnelled_);
  if (stretch_ > most_stretch_)
    text += fmt::format(
        "cloth was stretched to {:.2f} times its length at most; beyond {:.2f} liquid passes between its quadrature "
        "points\n",
        stretch_, most_stretch_);
  if (escaped_ > 0)
    text += fmt::format("{} particles left the domain in steps that lost over a quarter of all\n", escaped_);
  if (clamped_ > 0) text += fmt::format("particles were pushed back out of bodies {} times\n", clamped_);
  return text;
}

std::string RunTotals::errors(const Model& model) const {
  if (steps_ == 0) return "";
  const auto steps = static_cast<double>(steps_);
  std::string text;
  if (model.has_moving_liquid())
    text +=
        fmt::format("density {:.2g} % on average, {:.2g} % in the worst step{}", 100 * density_.sum / steps,
                    100 * density_.most, model.scene.time.mode == TimeMode::error ? "" : " (as the solve predicts)");
  if (model.has_moving_cloth())
    text += fmt::format("{}cloth residual {:.2g} of its tolerance on average, {:.2g} at worst",
                        text.empty() ? "" : "; ", cloth_.sum / steps, cloth_.most);
  if (model.has_exchange())
    text += fmt::format("{}saturation per step {:.2g} % on average, {:.2g} % at worst", text.empty() ? "" : "; ",
                        100 * saturation_.sum / steps, 100 * saturation_.most);
  return text.empty() ? "" : "errors: " + text;
}

std::string RunTotals::end(double time, double seconds, double mass_error) const {
  return fmt::format("{} step{} to t = {:.6g} s in {:.1f} s, mass error {:.3g} kg", steps_, steps_ == 1 ? "" : "s",
                     time, seconds, mass_error);
}

std::string RunTotals::stage_table(const std::vector<Stage>& stages) const {
  double total = 0;
  for (const Stage s : stages) total += milliseconds_[static_cast<std::size_t>(s)];
  const auto row = [&](std::string_view name, double ms) {
    return fmt::format("{:<18}{:>10.3f} s {:>10.3f} ms/step {:>6.1f} %\n", name, ms / 1000,
                       steps_ > 0 ? ms / static_cast<double>(steps_) : 0.0, total > 0 ? 100 * ms / total : 0.0);
  };
  std::string table;
  for (const Stage s : stages) table += row(name_of(s), milliseconds_[static_cast<std::size_t>(s)]);
  return table + row("all stages", total);
}

std::string RunTotals::array_table(const std::vector<NamedArray>& arrays) const {
  std::int64_t total = 0, small = 0;
  for (const NamedArray& a : arrays) total += a.bytes;
  const auto row = [&](std::string_view name, std::int64_t bytes) {
    const std::string share = particles_ > 0 ? fmt::format(" {:>10.1f} B/particle",
                                                           static_cast<double>(bytes) / static_cast<double>(particles_))
                                             : "";
    return fmt::format("{:<42}{:>10.2f} MiB{}\n", name, static_cast<double>(bytes) / (1 << 20), share);
  };
  std::string table;
  for (const NamedArray& a : arrays)
    if (100 * a.bytes >= total)
      table += row(a.name, a.bytes);
    else
      small += a.bytes;
  return table + row("smaller arrays", small) + row("all arrays at the end", total);
}

}  // namespace drench
