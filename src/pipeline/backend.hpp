#pragma once
// The one interface between the pipeline and whatever computes: the Kokkos backend or the serial reference.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "pipeline/stage_list.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

struct SetupSize;
struct MemoryEstimate;

/// What a stage is told about the step.
struct StepInfo {
  std::int64_t step = 0;
  double time = 0;                                                     // s, at the step's beginning
  double dt = 0;                                                       // s
  double fluid_speed_limit = std::numeric_limits<double>::infinity();  // m/s (failure.hpp)
};

/// Particles that something happened to: how many, and the lowest of their ids.
struct SomeParticles {
  std::int64_t count = 0;
  std::array<std::int64_t, 8> lowest{};
  std::string names() const;  ///< "3 17", or the first eight and "…"
};

/// What the stages report about one step; each stage fills in its own part.
struct StepReport {
  double dt_wanted = 0;  // s, from time_step
  int divergence_iterations = 0;
  double divergence_error = 0;  // 1: mean of max(0, Dδ/Dt) Δt
  bool divergence_converged = true;
  int density_iterations = 0;
  double density_error = 0;      // 1: mean of max(0, δ_adv − 1) after the solve
  double density_error_max = 0;  // 1: its maximum
  bool density_converged = true;
  int cloth_iterations = 0;
  double cloth_residual = 0;    // 1: unbalanced forces over their goal (cloth.hpp); converged at ≤ 1
  bool cloth_converged = true;  // stage cloth's solve
  /// The residual of the coupled solve (pressure.hpp). It begins where stage cloth's solve ended, as if that had converged:
  /// what that one left is left.
  void note_cloth_residual(double coupled) {
    cloth_residual = cloth_converged ? coupled : std::max(cloth_residual, coupled);
  }
  std::int64_t cloth_contacts = 0;    // pairs of the cloth with itself in contact (self_collision)
  std::int64_t cloth_zone_nodes = 0;  // cloth nodes in impact zones, the failsafe
  int diffusion_substeps = 0;
  std::int64_t collisions = 0;  // particles stopped at a cloth triangle (CCD)
  std::int64_t clamped = 0;     // particles put back by a body's failsafe
  std::int64_t nonfinite = 0;   // particles, nodes and bodies with a NaN or infinity
  // ledger
  Quanta mass_fluid = 0, mass_cloth = 0, mass_drained = 0, mass_supplied = 0;
  double mass_float = 0;      // kg: compensated sum of the floating-point masses of particles and nodes
  double saturation_max = 0;  // 1
  double kinetic_energy = 0;  // J: liquid particles and wet cloth nodes
  std::int64_t particles = 0;
  // measures (measures.hpp), 1
  double nearest_variance = 0, close_share = 0, wet_isotropy = 0;
  // what a run is watched by (pipeline/failure.hpp; advection.hpp, laws 6 and 7); from the ledger but for `escaped`
  double fluid_speed = 0, cloth_speed = 0;      // m/s: the fastest particle and node
  double cloth_stretch = 0;                     // 1: the largest length of an edge over that at rest
  std::int64_t tunnelled = 0, lowest_tunnelled = -1;  // particles that went through a cloth; the lowest of their ids
  SomeParticles escaped;                           // left the domain in this step, if suspiciously many or fast
  double escaped_speed = 0;                        // m/s: of the fastest particle that left the domain

  Quanta mass_total() const { return mass_fluid + mass_cloth + mass_drained - mass_supplied; }
};

/// A backend owns a copy of the state. Calls come from one thread. Errors are std::runtime_error.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;         ///< "kokkos" or "reference"
  virtual std::string description() const = 0;  ///< execution space, device, precision
  virtual void upload(const HostState& state) = 0;
  virtual void run(Stage stage, const StepInfo& info, StepReport& report) = 0;
  /// Waits for all work that was launched; for timers.
  virtual void fence() = 0;
  virtual HostState download() const = 0;
  /// Neighbour lists as sets, for tests: pairs (a, b) of the named list, sorted by a; "fluid_fluid",
  /// "fluid_boundary", "fluid_sample", "sample_fluid", "sample_sample", "sample_boundary".
  virtual std::vector<std::pair<Index, Index>> neighbor_pairs(const std::string& list) const = 0;
};

std::unique_ptr<Backend> make_reference_backend(const Model& model);
std::unique_ptr<Backend> make_kokkos_backend(const Model& model);

/// What the Kokkos backend's arrays take, in bytes, for a scene of this size (setup/memory_estimate.hpp): with numbers of
/// `real_bytes`, 4 or 8, and in a GPU's memory or the host's, whatever this build is for. Needs no BackendRuntime.
MemoryEstimate kokkos_array_bytes(const SetupSize& size, int real_bytes, bool gpu);

}  // namespace drench
