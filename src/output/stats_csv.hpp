#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/backend.hpp"
#include "pipeline/stage_list.hpp"

namespace drench {

/// stats.csv: one row per step. Masses in kg, times in s, kinetic_energy in J, ms_step and ms_<stage>, milliseconds of
/// wall time of the whole step and of each stage that runs (on a GPU a stage's work is waited for under --profile only, a
/// step's always), cloth_iterations and cloth_residual where cloth moves, nearest_variance, close_share and wet_isotropy
/// (1, stages/measures.hpp) where the scene asks for measures. mass_error is the change of mass_total since the start, from
/// integers: 0 means exactly 0.
class StatsCsv {
 public:
  /// `quantum` in kg. With `after`, the rows of a file that is there stay up to this step, whatever comes after them is
  /// cut off, and the next ones follow. Throws std::runtime_error when the file cannot be written.
  StatsCsv(const std::filesystem::path& path, const std::vector<Stage>& stages, double quantum, Quanta initial_total,
           std::int64_t after = -1);
  /// The row is in the file when this returns.
  void write(const StepReport& report, const std::array<double, stage_count>& milliseconds, double step_milliseconds);

  /// Puts the rows onto the disk itself. Throws std::runtime_error.
  void sync() const;

  /// The file's first lines, up to the row of this step (0: the header alone); none if it has not got that far.
  static std::optional<std::string> rows_until(const std::filesystem::path& path, std::int64_t step);

 private:
  std::filesystem::path path_;
  std::ofstream out_;
  std::vector<Stage> stages_;
  bool moving_cloth_, measures_;
  double quantum_;
  Quanta initial_total_;
};

}  // namespace drench
