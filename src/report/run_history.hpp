#pragma once
// run.log, read back: how a run ended, why, and what it warned of.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace drench {

enum class Ending {
  done,
  interrupted,  // Ctrl-C
  failed,       // a stage could not go on
  stopped,      // an error outside of the stages, such as a full disk
  unfinished,   // still running, or killed
};

struct RunFailureText {
  std::string stage;      // "" when it was not a stage that failed
  std::int64_t step = 0;  // the step that failed
  std::string time;       // s, as the log has it
  std::string cause;      // with the ids of who is to blame
  std::string remedy;     // "" where the log has none
  std::string files;      // failure.vtu and the last checkpoint
};

struct RunHistory {
  Ending ending = Ending::unfinished;
  RunFailureText failure;             // of Ending::failed and stopped
  std::string begun, ended;           // "2026-11-24 06:38:56", local time of the machine; "" for none
  std::string scene;                  // path as it was given
  std::string memory;                 // "7.9 MiB": peak of the backend's arrays; "" when the run did not come to say it
  std::vector<std::string> warnings;  // each once, in their order
  std::vector<std::string> totals;    // of warnings, from the end of the run
  std::map<std::string, std::int64_t>
      not_converged;  // "density": steps of the last session; only once the run has ended
  int sessions = 0;   // 1, and 1 more for each time that the run was gone on with in its folder
};

/// Reads a log. One that is not there gives an unfinished run without sessions.
RunHistory read_history(const std::filesystem::path& log);

}  // namespace drench
