#pragma once
// The files of a run that another program steps: those of `drench run`, without checkpoints.

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "output/frame_queue.hpp"
#include "output/probes.hpp"
#include "output/run_folder.hpp"
#include "output/run_log.hpp"
#include "output/stats_csv.hpp"
#include "pipeline/pipeline.hpp"

namespace drench {

/// The model outlives it, and so do the backend and the pipeline or those that take their place.
class Recorder {
 public:
  /// Makes the folder, which must be new or empty (`overwrite`: or hold a run, whose files are removed), and writes the
  /// first frame. Throws FolderError, and std::runtime_error when a file cannot be written.
  Recorder(const std::string& folder, bool overwrite, const Model& model, const Backend& backend,
           const Pipeline& pipeline, const std::vector<std::string>& warnings);
  /// Adds the step that the pipeline has just taken.
  void step(const StepReport& report);
  void failed(const RunFailure& failure);
  /// Continues with another backend and pipeline.
  void use(const Backend& backend, const Pipeline& pipeline) {
    backend_ = &backend;
    pipeline_ = &pipeline;
  }
  /// Adds a frame of the current state, unless the last one shows it.
  void frame();
  /// Adds the last frame, waits for all of them and writes the report. Returns its path.
  std::filesystem::path finish();

 private:
  HostState state() const;

  const Model& model_;
  const Backend* backend_;
  const Pipeline* pipeline_;
  std::filesystem::path folder_;
  std::optional<FolderLock> lock_;
  RunLog log_;
  RunTotals totals_;
  std::optional<StatsCsv> stats_;
  std::optional<ProbeCsv> probes_;
  std::optional<FrameQueue> frames_;
  std::int64_t last_frame_step_ = -1;
  bool failed_ = false;
  double mass_error_ = 0;  // kg
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace drench
