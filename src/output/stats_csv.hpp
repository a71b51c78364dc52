#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/backend.hpp"
#include "pipeline/stage_list.hpp"

namespace drench {

/// What a row of stats.csv is made of.
struct StatsRow {
  const StepReport& report;
  const std::array<double, stage_count>& milliseconds;
  double step_milliseconds;
  double exchange_milliseconds = 0, sum_milliseconds = 0;  // of them, what ranks told each other
};

struct StatsColumn {
  std::string name;
  std::function<std::string(const StatsRow&)> text;
};

/// The solute of a run: its quantum in kg, 0 without one, and its quanta at the start.
struct SoluteTotal {
  double quantum = 0;
  Quanta initial = 0;
};

/// What a run has, beside its stages, that has columns.
struct StatsKinds {
  bool by_error = false;     // time.mode is error
  bool among_ranks = false;  // ranks tell each other something
  SoluteTotal solute{};
  std::vector<Index> fabrics{};  // numbers of the porous cloths, for stage fabric
};

/// stats.csv: one row per step, with the columns and units of docs/manual/output.md. Those of a stage stand there only
/// if it runs. mass_error is the change of mass_total since the start, from integers: 0 means exactly 0.
class StatsCsv {
 public:
  /// `quantum` in kg. With `after`, the rows of a file that is there stay up to this step, and what comes after them is
  /// cut off. The next ones follow with its columns, which an older drench may have written. Throws std::runtime_error
  /// when the file cannot be written, or has a column that is not known.
  StatsCsv(const std::filesystem::path& path, const std::vector<Stage>& stages, double quantum, Quanta initial_total,
           std::int64_t after = -1, const StatsKinds& kinds = {});
  /// The row is in the file when this returns.
  void write(const StatsRow& row);

  /// Puts the rows onto the disk itself. Throws std::runtime_error.
  void sync() const;

  /// The file's first lines, up to the row of this step (0: the header alone); none if it has not got that far.
  static std::optional<std::string> rows_until(const std::filesystem::path& path, std::int64_t step);

 private:
  /// Cuts the file off after that step, and takes its columns.
  void go_on(std::int64_t after);

  std::filesystem::path path_;
  std::ofstream out_;
  std::vector<StatsColumn> columns_;
};

}  // namespace drench
