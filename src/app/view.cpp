#include "app/view.hpp"

#ifdef DRENCH_HAS_VIEW

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <future>
#include <initializer_list>
#include <string>
#include <vector>

namespace drench {
namespace {

namespace fs = std::filesystem;

std::string viewer() {
  std::error_code ignored;
  return (fs::read_symlink("/proc/self/exe", ignored).parent_path() / "drench-view").string();
}

[[noreturn]] void cannot_start(int error) {
  throw ViewError(fmt::format("{}: cannot be started: {}{}", viewer(), std::strerror(error),
                              error == ENOENT ? "; `tools/build openmp float` builds it" : ""));
}

/// `silent`: it keeps no hold on the terminal or the pipe that drench writes to.
pid_t spawn(std::initializer_list<std::string> arguments, bool silent) {
  std::vector<std::string> words(arguments);
  words.insert(words.begin(), viewer());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);  // Ctrl-C is for the run
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (int file = 0; silent && file < 3; ++file) posix_spawn_file_actions_addopen(&files, file, "/dev/null", O_RDWR, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) cannot_start(error);
  return child;
}

}  // namespace

void become_viewer(char** arguments) {
  std::string program = viewer();
  std::vector<char*> argv{program.data()};
  while (*arguments) argv.push_back(*arguments++);
  argv.push_back(nullptr);
  std::fflush(nullptr);
  execv(argv[0], argv.data());
  cannot_start(errno);
}

bool viewer_can_open() {
  int status = 0;
  const pid_t child = spawn({"--probe"}, false);
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void start_viewer(const fs::path& folder) {
  // A thread's priority is its child's: the viewer gives way to the run while its libraries are still being loaded.
  std::async(std::launch::async, [&] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19);
    spawn({"--follow", folder.string()}, true);
  }).get();
}

}  // namespace drench

#endif
