#include "report/run_record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "output/run_folder.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// "key: value"; the value may have colons.
std::pair<std::string, std::string> entry(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon == std::string::npos) return {trimmed(line), ""};
  return {trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 2))};
}

/// A line of scene.yaml's head, as write_resolved_scene has it.
void take_head(RunRecord& run, const std::string& line) {
  auto [key, value] = entry(line);
  if (key == "version") run.version = value;
  if (key == "commit") run.commit = value;
  if (key == "precision") run.precision = value;
  if (key == "backend" && run.backend.empty()) {
    run.backend = value;
    return;
  }
  const bool known = key == "version" || key == "commit" || key == "precision" || key == "drench output";
  if (known || key.empty()) return;
  if (key == "device" && run.device.empty() && value.find(": ") != std::string::npos)
    std::tie(key, value) = entry(value);
  run.device.emplace_back(key, value);
}

void read_scene(RunRecord& run) {
  const fs::path path = run.folder / "scene.yaml";
  std::ifstream in(path, std::ios::binary);
  bool in_head = true;
  for (std::string line; std::getline(in, line);) {
    in_head = in_head && line.starts_with("#");
    if (in_head)
      take_head(run, line.substr(1));
    else if (!line.empty() || !run.scene_text.empty())
      run.scene_text += line + "\n";
  }
  run.scene = yaml::parse(run.scene_text, path.string());
}

}  // namespace

const yaml::Value* RunRecord::find(const std::string& dotted) const {
  const yaml::Value* at = &scene;
  std::istringstream keys(dotted);
  for (std::string key; at && std::getline(keys, key, '.');) at = at->find(key);
  return at;
}

std::optional<double> RunRecord::number(const std::string& dotted) const {
  const yaml::Value* value = find(dotted);
  if (!value || value->kind != yaml::Value::Kind::scalar) return std::nullopt;
  char* end = nullptr;
  const double x = std::strtod(value->text.c_str(), &end);
  return *end || value->text.empty() || !std::isfinite(x) ? std::nullopt : std::optional<double>(x);
}

std::string RunRecord::device_entry(const std::string& key) const {
  for (const auto& [name_of_entry, value] : device)
    if (name_of_entry == key) return value;
  return "";
}

std::vector<std::string> RunRecord::stages() const {
  std::vector<std::string> names;
  for (const std::string& column : stats.names())
    if (column.starts_with("ms_") && column != "ms_step") names.push_back(column.substr(3));
  return names;
}

RunRecord read_run(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw FolderError(fmt::format("{}: no such folder", folder.string()));
  if (!holds_run(folder))
    throw FolderError(
        fmt::format("{}: holds no output of a run; allowed: a folder that drench run has written", folder.string()));
  RunRecord run;
  run.folder = folder;
  run.name = fs::weakly_canonical(folder).filename().string();
  read_scene(run);
  run.history = read_history(folder / "run.log");
  run.stats = StatsTable(folder / "stats.csv");
  run.energy = StatsTable(folder / "energy.csv", "time");
  return run;
}

}  // namespace drench
