#pragma once
// Starts the real program as a user would: in a folder of its own, with what it prints and its exit code.

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "paths.hpp"

namespace drench::test {

namespace fs = std::filesystem;

/// A new folder that is removed with everything in it.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (fs::temp_directory_path() / "drench_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TempFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline void write_text(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

inline std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

/// Names of everything in a folder, sorted.
inline std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

struct Outcome {
  int code = -1;  // the exit code; 1000 + signal when a signal ended the program
  std::string out, err;
};

/// Runs a program, found along PATH, with its arguments in folder `where`. With `when`, sends `signal` as soon as it
/// returns true. No file may become longer than `longest_file`, in bytes. One that takes longer than two minutes is
/// killed (code 1009).
inline Outcome run_words(const fs::path& where, std::vector<std::string> words,
                         const std::function<bool()>& when = nullptr, int signal = SIGINT,
                         rlim_t longest_file = RLIM_INFINITY) {
  const TempFolder log;
  const std::string out = log.path() / "out", err = log.path() / "err";
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (auto& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    const int to_out = open(out.c_str(), O_WRONLY | O_CREAT, 0600),
              to_err = open(err.c_str(), O_WRONLY | O_CREAT, 0600);
    if (to_out < 0 || to_err < 0 || chdir(where.c_str()) != 0) _exit(126);
    dup2(to_out, STDOUT_FILENO);
    dup2(to_err, STDERR_FILENO);
    const rlimit limit{longest_file, RLIM_INFINITY};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(126);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  const auto begin = std::chrono::steady_clock::now();
  int status = 0;
  bool sent = false;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (when && !sent && when()) {
      kill(child, signal);
      sent = true;
    }
    if (std::chrono::steady_clock::now() - begin > std::chrono::minutes(2)) kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status), read_text(out), read_text(err)};
}

/// Runs the program with `arguments`, as run_words does.
inline Outcome run_drench(const fs::path& where, const std::vector<std::string>& arguments,
                          const std::function<bool()>& when = nullptr, int signal = SIGINT,
                          rlim_t longest_file = RLIM_INFINITY) {
  std::vector<std::string> words{program()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_words(where, std::move(words), when, signal, longest_file);
}

/// stats.csv as rows of named columns.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  const std::string& text(std::size_t row, const std::string& column) const {
    const auto at = std::find(header.begin(), header.end(), column);
    if (at == header.end()) throw std::runtime_error("no column " + column);
    return rows.at(row).at(static_cast<std::size_t>(at - header.begin()));
  }
  double number(std::size_t row, const std::string& column) const { return std::stod(text(row, column)); }
};

inline Table read_table(const fs::path& path) {
  Table table;
  for (const std::string& line : split(read_text(path), '\n')) {
    if (table.header.empty())
      table.header = split(line, ',');
    else
      table.rows.push_back(split(line, ','));
  }
  return table;
}

}  // namespace drench::test
