#include "app/python.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
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

std::string interpreter(const PythonEnvironment& environment) {
  if (const char* named = std::getenv(environment.variable); named && *named) return named;
  const fs::path own = find_above_program({std::string(environment.folder) + "/bin/python"});
  return own.empty() ? "python3" : own.string();
}

std::vector<std::string> command_of(const std::string& script, const std::vector<std::string>& words,
                                    const PythonEnvironment& environment) {
  const fs::path path = find_above_program({"share/drench/export/" + script, "tools/export/" + script});
  if (path.empty())
    throw ExportError(fmt::format(
        "share/drench/export/{} is missing in the folders above the program: install drench again", script));
  std::vector<std::string> all{interpreter(environment), "-B", path.string()};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

/// Returns only if that fails.
void execute(std::vector<std::string>& all) {
  std::vector<char*> argv;
  argv.reserve(all.size() + 1);
  for (std::string& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
}

}  // namespace

void become_python(const std::string& script, const std::vector<std::string>& words,
                   const PythonEnvironment& environment) {
  std::vector<std::string> all = command_of(script, words, environment);
  std::fflush(nullptr);
  execute(all);
  throw ExportError(fmt::format("{}: cannot be started: {}; {}", all[0], std::strerror(errno), environment.remedy));
}

std::string run_python(const std::string& script, const std::vector<std::string>& words,
                       const PythonEnvironment& environment) {
  std::vector<std::string> all = command_of(script, words, environment);
  std::fflush(nullptr);
  int ends[2];
  if (pipe(ends) != 0) throw ExportError(fmt::format("{}: no pipe: {}", all[0], std::strerror(errno)));
  const pid_t child = fork();
  if (child < 0) throw ExportError(fmt::format("{}: cannot be started: {}", all[0], std::strerror(errno)));
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execute(all);
    std::fprintf(stderr, "drench: %s: cannot be started: %s; %s\n", all[0].c_str(), std::strerror(errno),
                 environment.remedy);
    _exit(127);
  }
  close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t got = 0; (got = read(ends[0], part, sizeof part)) > 0 || (got < 0 && errno == EINTR);)
    if (got > 0) text.append(part, static_cast<std::size_t>(got));
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw ExportError("");
  return text;
}

}  // namespace drench
