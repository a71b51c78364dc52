#pragma once
// The one interface between the pipeline and whatever computes: the Kokkos backend or the serial reference.

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/stage_list.hpp"
#include "pipeline/step_report.hpp"
#include "state/field_view.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

struct SetupSize;
struct MemoryEstimate;
class Communicator;

/// What a stage is told about the step.
struct StepInfo {
  std::int64_t step = 0;
  double time = 0;                                                     // s, at the step's beginning
  double dt = 0;                                                       // s
  double fluid_speed_limit = std::numeric_limits<double>::infinity();  // m/s (failure.hpp)
  double divergence_start = 0, density_start = 0;                      // StepReport's, of the step before
  /// s of docs/theory/liquid.md, Eq. 24: the share, less than 1 in a step that is cut short, of what a step corrects of
  /// density errors, of gaps between layers and of overlaps of bodies.
  double correction_share = 1;
};

/// A backend owns a copy of the state. Calls come from one thread at a time, while other threads may use other
/// backends. Errors are std::runtime_error.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;         ///< "kokkos" or "reference"
  virtual std::string description() const = 0;  ///< execution space, device, precision
  /// The share of a pair's force in the density solve that is rounded away, where that is more than the precision's.
  virtual double pair_rounding() const { return 0; }
  virtual void upload(const HostState& state) = 0;
  virtual void run(Stage stage, const StepInfo& info, StepReport& report) = 0;
  /// Waits for all work that was launched; for timers.
  virtual void fence() = 0;
  virtual HostState download() const = 0;
  /// Keeps a copy of the state, for go_back.
  virtual void keep() = 0;
  /// The state is again as keep found it.
  virtual void go_back() = 0;
  /// The arrays themselves, each field that the model needs; none where a backend does not show them. All work is done.
  virtual std::vector<FieldView> fields() const { return {}; }
  /// HostState's body_position, body_orientation, body_velocity and body_angular_velocity; the rest may be empty.
  virtual HostState body_states() const { return download(); }
  /// What acts on each body in the last step, which took `dt` (s); none for bodies that are not measured.
  virtual std::vector<std::optional<BodyLoad>> body_loads(double) const { return {}; }
  /// The model's bodies, pins, jets or wind have changed since the last step (drench/prescribed.hpp).
  virtual void model_changed() {}
  /// Neighbour lists as sets, for tests: pairs (a, b) of the named list, sorted by a; "fluid_fluid",
  /// "fluid_boundary", "fluid_sample", "sample_fluid", "sample_sample", "sample_boundary".
  virtual std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const = 0;
};

std::unique_ptr<Backend> make_reference_backend(const Model& model);
std::unique_ptr<Backend> make_kokkos_backend(const Model& model);
/// The same with the liquid spread over ranks; null: one alone. Every call to the backend is made on all of them, in
/// the same order. download() has all of the liquid on rank 0, and the rank's own elsewhere.
std::unique_ptr<Backend> make_kokkos_backend_on(const Communicator* ranks, const Model& model);

/// What the Kokkos backend's arrays take, in bytes, for a scene of this size (setup/memory_estimate.hpp): with numbers
/// of `real_bytes`, 4 or 8, and in a GPU's memory or the host's, whatever this build is for. Needs no BackendRuntime.
MemoryEstimate kokkos_array_bytes(const SetupSize& size, int real_bytes, bool gpu);

}  // namespace drench
