#pragma once
// What a run has computed, to be set beside another run byte for byte.

#include <map>

#include "run_program.hpp"

namespace drench::test {

/// What a run has computed, by file: frames, collections and checkpoints in bytes, stats.csv without its wall times and
/// what tells of the ranks.
inline std::map<std::string, std::string> results_in(const fs::path& folder, bool with_checkpoints = true) {
  std::map<std::string, std::string> results;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name == "run.log" || name == "scene.yaml") continue;
    if (name.ends_with(".drench") && !with_checkpoints) continue;
    results[name] = read_text(entry.path());
  }
  const Table stats = read_table(folder / "stats.csv");
  std::string& rows = results["stats.csv"];
  rows.clear();
  for (const auto& row : stats.rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      if (!stats.header.at(c).starts_with("ms_") && stats.header.at(c) != "imbalance") rows += row[c] + ',';
    rows += '\n';
  }
  return results;
}

/// Names the files that differ; without checkpoints, whose times may be others.
inline std::string difference(const fs::path& a, const fs::path& b, bool with_checkpoints = true) {
  const auto one = results_in(a, with_checkpoints), two = results_in(b, with_checkpoints);
  std::string names;
  for (const auto& [name, text] : one)
    if (!two.contains(name) || two.at(name) != text) names += name + ' ';
  for (const auto& [name, text] : two)
    if (!one.contains(name)) names += "+" + name + ' ';
  return names;
}

}  // namespace drench::test
