#pragma once
// run.log and the run's totals: what was said, when, and what it came to.

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pipeline/backend.hpp"
#include "pipeline/runtime.hpp"
#include "pipeline/stage_list.hpp"

namespace drench {

/// Timestamped lines, on disk at once. Without a path it writes nothing.
class RunLog {
 public:
  RunLog() = default;
  /// Without `append` it replaces a log that is there.
  explicit RunLog(const std::filesystem::path& path, bool append = false);
  /// Each line of `text` becomes a line of the log.
  void write(const std::string& text);

 private:
  std::ofstream out_;
};

/// Sums over the steps of a run.
class RunTotals {
 public:
  /// `most_stretch`: of cloth, beyond which liquid gets between its samples (Model::most_stretch()), 1.
  explicit RunTotals(double most_stretch) : most_stretch_(most_stretch) {}
  /// Adds a step (as numbered after it); returns lines to log when a solver did not converge, particles went through a
  /// cloth, cloth was stretched too far or suspiciously many left the domain (advection.hpp, laws 6 and 7) for the
  /// first time, else "".
  std::string add(std::int64_t step, double time, const StepReport& report,
                  const std::array<double, stage_count>& milliseconds);
  /// Lines about solvers that did not converge, cloth that was stretched too far and particles that were put back, went
  /// through cloth or escaped; "" when there is nothing to say.
  std::string warnings() const;
  /// One line: what the density solve and the motion left, the cloth's residual, and the saturation's step error, on
  /// average and at worst; "" for a scene without all of them.
  std::string errors(const Model& model) const;
  /// One line: how many steps took how many seconds, up to which simulated time (s), and the mass error (kg).
  std::string end(double time, double seconds, double mass_error) const;
  /// Table of the stages' total times, one line each.
  std::string stage_table(const std::vector<Stage>& stages) const;
  /// Table of the backend's arrays (named_arrays()), in all and for each particle of the last step; arrays below 1 % of
  /// all share one line.
  std::string array_table(const std::vector<NamedArray>& arrays) const;
  const std::array<double, stage_count>& milliseconds() const { return milliseconds_; }
  std::int64_t steps() const { return steps_; }

 private:
  struct Solver {
    const char* name;
    std::int64_t failures = 0, first_step = 0, last_step = 0;
    double worst = 0;
    double worst_cloth = 0;  // of the density solve: its cloth's residual over its goal, where that had not converged
  };
  std::array<Solver, 3> solvers_{Solver{"divergence solve"}, Solver{"density solve"}, Solver{"cloth solve"}};
  double most_stretch_, stretch_ = 0;
  struct Mean {
    double sum = 0, most = 0;
    void add(double value) {
      sum += value;
      most = std::max(most, value);
    }
  };
  Mean density_, cloth_, saturation_;  // 1
  std::int64_t particles_ = 0;         // of the last step
  std::int64_t steps_ = 0, clamped_ = 0, tunnelled_ = 0, escaped_ = 0;
  std::array<double, stage_count> milliseconds_{};
};

}  // namespace drench
