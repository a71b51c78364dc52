#pragma once
// drench in other programs: a scene, from a file or made in code, and its run, step by step. With what this header
// includes, it is all that `cmake --install` puts into include/; examples/embed shows it in use.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/runtime.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "scene/setup_error.hpp"
#include "state/host_state.hpp"
#include "state/types.hpp"

namespace drench {

/// A run of a scene on the backend of this build. A BackendRuntime must live as long; all calls come from one thread.
class Simulation {
 public:
  /// Throws SceneError for a value that a scene file may not have either, SetupError for a scene that cannot be set up or
  /// does not fit in memory, DeviceError without a device.
  explicit Simulation(const Scene& scene);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step of at most `longest` s; returns how long it was. Throws std::runtime_error when the run cannot go on.
  double step(double longest = std::numeric_limits<double>::infinity());
  /// Steps that end exactly at `time`.
  void run_until(double time);

  double time() const;         ///< s
  std::int64_t steps() const;  ///< so far

  /// Everything that changes, as it is now: particles, cloth nodes, bodies. Copied from the device at each call.
  HostState state() const;
  /// Of each cloth node: liquid over what its pores hold; 0 where the cloth is not porous.
  std::vector<double> saturation(const HostState& state) const;
  /// The cloths' triangles, as numbers of nodes; those of one cloth follow each other, as do its nodes.
  const std::vector<std::array<Index, 3>>& triangles() const;
  double quantum() const;  ///< kg; masses in HostState are counts of it
  /// What `drench check` would warn of.
  const std::vector<std::string>& warnings() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace drench
