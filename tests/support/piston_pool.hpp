#pragma once
// A pool that a piston of mesh files pushes at, and how much floor the piston takes from the water.

#include <fmt/format.h>

#include <string>

#include "validation.hpp"

namespace drench::test {

/// Mean height of the liquid's particles, m.
inline double mean_height(const HostState& s) {
  double sum = 0;
  for (const Vec3& x : s.fluid_position) sum += x[1];
  return sum / s.fluid_count();
}

/// Of the pool, m: spacing, length along the piston's way, width across it.
struct PistonPool {
  double spacing = 0.01, length = 0.3, width = 0.08;

  /// m²: the floor that the files' piston has taken when it has come, between 1 s and 3.5 s. The level is twice the
  /// height of the centre of mass, and level times floor is the volume. Calls each(run, state) after every step; body 1
  /// is the piston.
  template <class Each>
  double floor_taken(const std::string& files, double fps, Each&& each) const {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10, mode: cfl}}
domain: {{min: [-0.3, -0.1, -0.2], max: [0.5, 1, 0.2]}}
output: {{every: 0}}
fluid:
  spacing: {0}
  viscosity: 2.0e-3
  solver: {{density_error: 1.0e-4, divergence_error: 1.0e-4}}
  sources: [{{block: {{min: [0, 0, -{1}], max: [{2}, 0.1, {1}]}}}}]
bodies:
  - box: {{min: [-0.2, 0, -{1}], max: [{2}, 0.6, {1}], inside: true}}
  - mesh: {{sequence: "{3}", fps: {4}}}
)",
                             spacing, width / 2, length, files, fps));
    double before = 0, after = 0;
    int samples_before = 0, samples_after = 0;
    while (run.time() < 4) {
      run.step();
      const HostState s = run.state();
      each(run, s);
      if (run.time() > 0.6 && run.time() < 1) before += mean_height(s), ++samples_before;
      if (run.time() > 3.5) after += mean_height(s), ++samples_after;
    }
    const double volume = run.initial().fluid_count() * spacing * spacing * spacing;
    return volume / 2 * (samples_before / before - samples_after / after);
  }
};

}  // namespace drench::test
