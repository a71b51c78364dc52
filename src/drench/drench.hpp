#pragma once
// drench in other programs: a scene, from a file or made in code, and its run, step by step. This header and those that it
// includes are all that `cmake --install` puts into include/. examples/embed shows them in use; docs/api has their book.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "pipeline/runtime.hpp"
#include "pipeline/step_report.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "setup/setup_error.hpp"
#include "state/host_state.hpp"

/// Water meeting porous cloth. All quantities are in SI units.
namespace drench {

/// A run of a scene on the backend of this build. A BackendRuntime must outlive it. All calls come from one thread.
class Simulation {
 public:
  /// Sets the scene up: its geometry, its samples, its arrays on the device. The scene is checked as a file would be.
  /// @throws SceneError for a value that a scene file may not have either
  /// @throws SetupError for a scene that cannot be set up, or does not fit in memory
  /// @throws DeviceError without a device
  explicit Simulation(const Scene& scene);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step.
  /// @param longest the step is not longer than this, s
  /// @returns what the step did: its length, iterations and errors of its solves, masses, speeds. Each is one number for all
  ///   of the scene; reading them costs nothing
  /// @throws std::invalid_argument unless `longest` is above 0
  /// @throws std::runtime_error when the run cannot go on; its text says why. The state is then that of half a step
  StepReport step(double longest = std::numeric_limits<double>::infinity());
  /// Steps until the run's time is `time`, s; none if it is there already, or past it. Throws as step() does.
  void run_until(double time);

  double time() const;         ///< s, simulated since the start
  std::int64_t steps() const;  ///< number of steps since the start

  /// Everything that changes, as it is now: arrays with an entry for each particle, cloth node, sample and body, in SI units
  /// but for masses (quanta). Particles are in the order of their ids. Each call copies it from the device.
  HostState state() const;
  /// Saturation of each cloth node of `state`, 1: liquid over what the node's pores hold, and 0 where the cloth is not
  /// porous. As long as HostState::node_position.
  std::vector<double> saturation(const HostState& state) const;
  /// Triangles of all cloths, each as the indices of its three nodes in HostState::node_position. The triangles of one cloth
  /// follow each other, and so do its nodes. They stay the same during a run.
  const std::vector<std::array<Index, 3>>& triangles() const;
  double quantum() const;  ///< kg; masses in HostState are multiples of it
  /// The warnings that `drench check` prints for this scene, a line each.
  const std::vector<std::string>& warnings() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace drench
