#include "output/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <regex>
#include <vector>

#include "base/version.hpp"
#include "output/text_file.hpp"
#include "scene/load.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

constexpr const char* marker = "# drench output: the scene of this run, with every default";

bool taken(const fs::path& path) { return fs::exists(path) && !(fs::is_directory(path) && fs::is_empty(path)); }

void remove_matching(const fs::path& where, const std::regex& ours) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(where))
    if (entry.is_regular_file() && std::regex_match(entry.path().filename().string(), ours))
      found.push_back(entry.path());
  for (const auto& path : found) fs::remove(path);
}

/// What a run leaves that was killed before it wrote scene.yaml.
bool holds_beginning_only(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (!entry.is_regular_file() || entry.path().filename() != temporary_name("scene.yaml")) return false;
  return true;
}

void remove_run(const fs::path& folder) {
  static const std::regex top(R"((fluid|surface|cloth|bodies)\.pvd|stats\.csv|run\.log|scene\.yaml|failure\.vtu|)"
                              R"(report\.html|checkpoint_\d{6,}\.drench)");
  static const std::regex frame(R"((fluid|surface|cloth|bodies)_(\d{6,}|static)\.vtu)");
  remove_unfinished(folder);
  remove_matching(folder, top);
  if (fs::is_directory(folder / "frames")) {
    remove_matching(folder / "frames", frame);
    if (fs::is_empty(folder / "frames")) fs::remove(folder / "frames");
  }
}

RunFolder choose(const std::optional<std::string>& requested, const std::string& scene_path, bool overwrite,
                 const FolderWords& words) {
  const fs::path wanted = requested ? fs::path(*requested) : fs::path("out") / fs::path(scene_path).stem();
  if (!taken(wanted)) return {wanted, ""};
  if (fs::exists(wanted) && !fs::is_directory(wanted) && requested)
    throw FolderError(fmt::format("{}: is not a folder; {}", wanted.string(), words.other));
  if (overwrite) {
    if (!holds_run(wanted) && !holds_beginning_only(wanted))
      throw FolderError(fmt::format("{}: is not empty and contains no output of drench, so {} leaves it unchanged; {}",
                                    wanted.string(), words.overwrite, words.other));
    const FolderLock lock(wanted);
    remove_run(wanted);
    return {wanted, ""};
  }
  if (requested && !words.overwrite)
    throw FolderError(fmt::format("{}: is not empty; {}", wanted.string(), words.other));
  if (requested)
    throw FolderError(fmt::format("{}: is not empty; {}, or give {} to replace an earlier run's files", wanted.string(),
                                  words.other, words.overwrite));
  for (int n = 2;; ++n) {
    const fs::path sibling = fmt::format("{}-{}", wanted.string(), n);
    if (!taken(sibling))
      return {sibling, fmt::format("{} is not empty: writing to {}", wanted.string(), sibling.string())};
  }
}

}  // namespace

bool holds_run(const fs::path& folder) {
  std::ifstream in(folder / "scene.yaml");
  std::string line;
  return std::getline(in, line) && line == marker;
}

void remove_unfinished(const fs::path& folder) {
  static const std::regex part(
      R"(\.(((fluid|surface|cloth|bodies)(_\w+\.vtu|\.pvd))|(\w+\.(csv|yaml|vtu|drench|html)))\.part)");
  remove_matching(folder, part);
  if (fs::is_directory(folder / "frames")) remove_matching(folder / "frames", part);
}

FolderLock::FolderLock(const fs::path& folder) : file_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (file_ < 0 || flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
    return;  // some file systems have no locks
  close(file_);
  throw FolderError(fmt::format("{}: another run of drench is writing there", folder.string()));
}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
}

RunFolder make_run_folder(const std::optional<std::string>& requested, const std::string& scene_path, bool overwrite,
                          const FolderWords& words) {
  try {
    RunFolder folder = choose(requested, scene_path, overwrite, words);
    fs::create_directories(folder.path);
    return folder;
  } catch (const fs::filesystem_error& e) {
    throw FolderError(fmt::format("{}: cannot be made: {}", e.path1().string(), e.code().message()));
  }
}

void write_resolved_scene(const fs::path& folder, const Scene& scene, const std::string& backend_name,
                          const std::string& backend_description) {
  std::string head = fmt::format("{}\n# version: {}\n# commit: {}\n# precision: {}\n# backend: {}\n", marker,
                                 version_string, git_commit, precision_name, backend_name);
  std::string line = "# device: ";
  for (const char c : backend_description) {
    line += c;
    if (c == '\n') line += "#   ";
  }
  write_atomically(folder / "scene.yaml", head + line + "\n\n" + resolved_yaml(scene));
}

std::string run_heading(const std::string& backend_name, const std::string& backend_description,
                        const std::string& scene) {
  return fmt::format("drench {} ({}, {} precision), backend {}: {}\nscene {}", version_string, git_commit,
                     precision_name, backend_name, backend_description, scene);
}

}  // namespace drench
