#pragma once
// probes.csv: what the scene's probes measure, docs/manual/output.md, Probes.

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

#include "pipeline/backend.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

class ProbeCsv {
 public:
  /// `file`: empty for a rank that only takes part. `start`: the state before the first step. With `after` ≥ 0 an
  /// existing file keeps its rows up to this time (s).
  ProbeCsv(const std::filesystem::path& file, const Model& model, HostState start, double after = -1);
  /// Takes up a step, and writes a row if one is due. `loads`: of the step; `state`: at its end.
  void step(const StepReport& report, const std::function<std::vector<std::optional<BodyLoad>>()>& loads,
            const std::function<HostState()>& state);
  /// What the next row needs of the steps before, for a checkpoint; and the same from a checkpoint. Sums of other
  /// probes are ignored.
  std::vector<double> sums() const;
  void take_up(const std::vector<double>& sums);
  /// Puts the rows onto the disk itself.
  void sync() const;

 private:
  /// A particle at the end of a step.
  struct Place {
    std::int64_t id = 0;
    Quanta mass = 0;
    Vec3 position{}, velocity{};
  };

  struct Disc {
    std::size_t probe = 0;
    Vec3 center{}, normal{};  // the normal of length 1
    double radius = 0;        // m
  };

  std::string header() const;
  void add_loads(double dt, const std::vector<std::optional<BodyLoad>>& loads);
  void add_state(double dt, const HostState& state);
  void add_passed(double dt, const HostState& state);
  void pass(const Vec3& from, const Vec3& to, Quanta mass);
  void write(const HostState& state);

  const Model& model_;
  std::filesystem::path path_;
  std::ofstream out_;
  double every_, next_, elapsed_ = 0;  // s
  bool has_bodies_ = false;            // is there a probe of a body?
  bool has_means_ = false;             // is there a probe that averages states?
  std::vector<Disc> discs_;
  std::vector<Index> target_;                   // of each probe: the number of its body or cloth
  std::vector<std::array<double, 6>> sum_;      // of each probe: what it averages, times time, since the last row
  std::vector<double> passed_, passed_before_;  // kg: of each disc, up to the last step and up to the last row
  std::vector<Place> last_;                     // of all particles at the last step, by id; only with discs
};

}  // namespace drench
