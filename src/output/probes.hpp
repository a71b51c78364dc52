#pragma once
// probes.csv: what the scene's probes measure, docs/manual/output.md, Probes.

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "pipeline/backend.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

class ProbeCsv {
 public:
  /// `file`: empty for a rank that only takes part. `after` ≥ 0: an existing file keeps its rows up to this time (s).
  ProbeCsv(const std::filesystem::path& file, const Model& model, double after = -1);
  /// Takes up a step, and writes a row if one is due. `loads`: of the step; `state`: at its end.
  void step(const StepReport& report, const std::function<std::vector<std::optional<BodyLoad>>()>& loads,
            const std::function<HostState()>& state);
  /// Puts the rows onto the disk itself.
  void sync() const;

 private:
  std::string header() const;
  void take_up(const std::string& row);
  void add_loads(double dt, const std::vector<std::optional<BodyLoad>>& loads);
  void add_state(double dt, const HostState& state);
  double passed_since(std::size_t k, const HostState& state);
  void write(const HostState& state);

  const Model& model_;
  std::filesystem::path path_;
  std::ofstream out_;
  double every_, next_, elapsed_ = 0;             // s
  bool has_bodies_ = false, has_states_ = false;  // is there a probe that averages loads; states?
  std::vector<Index> target_;                     // of each probe: the number of its body or cloth
  std::vector<std::array<double, 6>> sum_;        // of each probe: what it averages, times time, since the last row
  std::vector<std::unordered_map<std::int64_t, Vec3>> last_place_;  // of each disc: particles near it at the last row
  std::vector<double> passed_;                                      // of each disc, kg
};

}  // namespace drench
