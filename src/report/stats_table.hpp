#pragma once
// stats.csv or energy.csv in memory: columns of numbers by name.

#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

namespace drench {

/// A row a step or a frame. A last row that a killed run left unfinished is not there.
class StatsTable {
 public:
  StatsTable() = default;  ///< no columns, no rows
  /// Throws FolderError when the file is there but is no table of numbers that begins with the column `first` and has
  /// one named time. Without the file the table is empty.
  explicit StatsTable(const std::filesystem::path& path, const std::string& first = "step");
  std::size_t rows() const { return rows_; }
  const std::vector<std::string>& names() const { return names_; }
  bool has(const std::string& name) const { return columns_.contains(name); }
  /// As many numbers as rows, in the unit of docs/manual/output.md; none for a column that is not there.
  const std::vector<double>& column(const std::string& name) const;

 private:
  void add_row(const std::filesystem::path& path, const char* line, std::size_t number);

  std::vector<std::string> names_;
  std::vector<std::vector<double>*> in_order_;
  std::unordered_map<std::string, std::vector<double>> columns_;
  std::size_t rows_ = 0;
};

/// Of all its finite numbers; 0 for none.
struct Summary {
  double first = 0, last = 0, least = 0, most = 0, mean = 0, median = 0, sum = 0;
};
Summary summary_of(const std::vector<double>& values);

}  // namespace drench
