#pragma once
// probes.csv: what the scene's probes measure, docs/manual/output.md, Columns of probes.csv.

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "pipeline/backend.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// The liquid near a point, from particles within a radius of it.
struct LiquidAt {
  double pressure = 0;     // Pa: a linear fit's value there; 0 where no liquid is near
  Vec3 velocity{0, 0, 0};  // m/s: the same
  double filling = 0;      // 1: Σ V W, over what solids leave of it
};

/// Particles by place, for probes of one state, which must outlive it.
class LiquidProbe {
 public:
  LiquidProbe(const Model& model, const HostState& state, double largest_radius = 0);
  ~LiquidProbe();
  LiquidProbe(const LiquidProbe&) = delete;
  LiquidProbe& operator=(const LiquidProbe&) = delete;
  /// `radius` (m): over which a sensor averages; at least the support radius is used.
  LiquidAt at(const Vec3& x, double radius = 0) const;

 private:
  struct Points;
  const Model& model_;
  const HostState& state_;
  std::unique_ptr<Points> points_;
};

class ProbeCsv {
 public:
  /// `file`: empty for a rank that only takes part. `after` ≥ 0: rows up to this time (s) of a file that is there stay.
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
  bool is_of(std::size_t node, const ProbeScene& probe) const;
  double passed_since(std::size_t k, const HostState& state);
  void write(const HostState& state);

  const Model& model_;
  std::filesystem::path path_;
  std::ofstream out_;
  double every_, next_, elapsed_ = 0;             // s
  bool has_bodies_ = false, has_states_ = false;  // is there a probe that averages loads; states?
  std::vector<std::array<double, 6>> sum_;        // of each probe: what it averages, times time, since the last row
  std::vector<std::unordered_map<std::int64_t, Vec3>> last_place_;  // of each disc: particles near it at the last row
  std::vector<double> passed_;                                      // of each disc, kg
};

}  // namespace drench
