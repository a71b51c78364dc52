#pragma once
// Which checkpoint a run goes on from, and whether it may.

#include <filesystem>
#include <string>
#include <vector>

#include "output/checkpoint.hpp"
#include "pipeline/backend.hpp"

namespace drench {

struct Resume {
  Checkpoint checkpoint;
  std::filesystem::path path;         // of the checkpoint
  std::filesystem::path folder;       // of the run that wrote it, where that is still there; else ""
  std::vector<std::string> warnings;  // one line each
};

/// Who goes on: the command, which also needs the run's output up to there, or a program around the library.
enum class For { command, library };

/// The checkpoint `wanted`, or the newest one of the folder `wanted` that is whole (a warning tells of those that are
/// not). Throws CheckpointError: there is none, or it is not one of this scene, mesh files, version, precision and
/// backend; the first difference is named. The command takes none of a run whose pins, jets or wind a program changed.
Resume find_checkpoint(const std::string& wanted, const Model& model, const Backend& backend, For whom = For::command);

/// A checkpoint to be of a run of this model on this backend, but for its state.
Checkpoint checkpoint_header(const Model& model, const Backend& backend);

}  // namespace drench
