#pragma once
// A run's folder as a report sees it.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/run_history.hpp"
#include "report/stats_table.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

struct RunRecord {
  std::filesystem::path folder;
  std::string name;  // of the folder
  std::string version, commit, precision, backend;
  std::vector<std::pair<std::string, std::string>> device;  // "threads": "2", …, in the order of scene.yaml
  std::string scene_text;                                   // resolved, without the head
  yaml::Value scene;
  RunHistory history;
  StatsTable stats;
  StatsTable energy;  // energy.csv: a row a frame; of an older run none

  const yaml::Value* find(const std::string& dotted) const;       ///< a value of the scene, or null
  std::optional<double> number(const std::string& dotted) const;  ///< of the scene
  std::string device_entry(const std::string& key) const;         ///< "" for none
  /// Names of the stages that have a column of times, in their order.
  std::vector<std::string> stages() const;
};

/// Reads a run's folder. Throws FolderError when it holds no run or a damaged table, SceneError when its scene is
/// no YAML.
RunRecord read_run(const std::filesystem::path& folder);

}  // namespace drench
