#include "app/python.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/commands.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;

/// The first of `names` that there is in a folder above the program: a build tree's, an installation's or a pack's.
fs::path find_above_program(const std::vector<std::string>& names) {
  std::error_code ignored;
  fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (int level = 0; level < 5 && folder != folder.parent_path(); ++level, folder = folder.parent_path())
    for (const std::string& name : names)
      if (fs::exists(folder / name, ignored)) return folder / name;
  return {};
}

std::string interpreter() {
  if (const char* named = std::getenv("DRENCH_PYTHON"); named && *named) return named;
  const fs::path own = find_above_program({".deps/export-venv/bin/python"});
  return own.empty() ? "python3" : own.string();
}

}  // namespace

void become_python(const std::string& script, const std::vector<std::string>& words) {
  const fs::path path = find_above_program({"share/drench/export/" + script, "tools/export/" + script});
  if (path.empty())
    throw ExportError(
        fmt::format("share/drench/export/{} is not in a folder above the program: install drench anew", script));
  std::vector<std::string> all{interpreter(), "-B", path.string()};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  argv.reserve(all.size() + 1);
  for (std::string& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  execvp(argv[0], argv.data());
  throw ExportError(
      fmt::format("{}: cannot be started: {}; run tools/setup export, or name a Python that has usd-core in "
                  "DRENCH_PYTHON",
                  all[0], std::strerror(errno)));
}

}  // namespace drench
