#pragma once
// A run's state on disk: what it takes to go on as if nothing had happened, bit for bit. The file: the line "drench
// checkpoint 1", a record for each field of the struct and of its HostState (length of the name, name, bytes of an
// element, number of elements, elements; little-endian), and a checksum of it all.

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// A checkpoint that cannot be gone on from. One line that begins with its path.
struct CheckpointError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// One whose bytes are not what was written: the one before may be whole.
struct DamagedCheckpoint : CheckpointError {
  using CheckpointError::CheckpointError;
};

struct Checkpoint {
  std::string version, commit;     // of the drench that wrote it
  std::string precision, backend;  // that computed it
  std::string scene;               // resolved (to_yaml)
  std::uint64_t geometry = 0;      // checksum of what was read from mesh files and sampled (geometry_of)
  std::int64_t frames = 0;         // that were written on schedule
  std::uint8_t shortened = 0;      // 1: the last step was cut to end at time.end
  std::vector<double> changes;     // of bodies, pins, jets and wind by a program (drench/prescribed.hpp); empty: none
  std::vector<double> probe_sums;  // of ProbeCsv; empty: no probes
  HostState state;
};

/// Writes it beside `path` and moves it there once it is on the disk. Throws std::runtime_error when the disk refuses;
/// nothing is left then, and what was there is still there.
void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Reads one of this version. Throws CheckpointError: it cannot be read, is none, or is of another version; and
/// DamagedCheckpoint.
Checkpoint read_checkpoint(const std::filesystem::path& path);

/// checkpoint_000123.drench, after step 123.
std::string checkpoint_name(std::int64_t step);
/// The step in such a name; −1 for any other.
std::int64_t checkpoint_step(const std::filesystem::path& path);
/// A folder's checkpoints, the newest first.
std::vector<std::filesystem::path> checkpoints_in(const std::filesystem::path& folder);

/// A checksum of the model's meshes, samples and files of sequences.
std::uint64_t geometry_of(const Model& model);

}  // namespace drench
