// A viscous slab between two plates starts to move under a force along them: Poiseuille's flow as it develops.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double width = 0.1, viscosity = 1e-3, force = 0.01, pi = 3.14159265358979323846;  // m, m²/s, m/s²

/// Speed (m/s) at x between plates at 0 and `width`, from rest (Batchelor 1967, section 4.3).
double exact(double x, double t) {
  double u = force / (2 * viscosity) * x * (width - x);
  for (int n = 1; n < 40; n += 2) {
    const double k = n * pi / width;
    u -= 4 * force * width * width / (viscosity * std::pow(n * pi, 3)) * std::sin(k * x) *
         std::exp(-viscosity * k * k * t);
  }
  return u;
}

}  // namespace

TEST(channel, the_profile_between_plates_develops) {
  // Missed today, for two reasons. (1) On a lattice with h = 2 d the central form of the viscosity gives a shear along the
  // rows 0.70 ν: its fourth moment Σ V x² y² |∇W|/r/(r² + 0.01 h²) has only 12 neighbours to sum over. (Directions
  // averaged, as in a disordered liquid, it gives 0.99 ν.) (2) The liquid comes to rest at the walls' samples, half a
  // spacing behind the plates.
  // The sides and the ends of the slab are free: no shear acts on the sides, so that the flow is that between infinite
  // plates; the ends are cut off the comparison by more than one width. The slab moves by a third of a width.
  for (const int across : {8, 12}) {
    const double d = width / across, step = 0.1 * d * d / viscosity, end = 3;
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: {0}, end: 3}}
gravity: [0, {1}, 0]
domain: {{min: [-0.05, -0.4, -0.2], max: [0.15, 0.4, 0.2]}}
fluid:
  spacing: {2}
  viscosity: {3}
  sources: [{{block: {{min: [0, -0.2, {4}], max: [{5}, 0.2, {6}]}}}}]
bodies:
  - plane: {{point: [0, 0, 0], normal: [1, 0, 0]}}
  - plane: {{point: [{5}, 0, 0], normal: [-1, 0, 0]}}
)",
                             step, -force, d, viscosity, -3 * d, width, 3 * d));
    while (run.time() < end - 1e-9) run.step(end - run.time());
    const HostState s = run.state();
    double square = 0, wall = 0;
    int count = 0, at_wall = 0;
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3& x = s.fluid_position[i];
      if (std::fabs(x[1] + 0.02) > 0.06) continue;
      const double error = -s.fluid_velocity[i][1] - exact(x[0], end);
      square += error * error;
      ++count;
      if (x[0] > d && x[0] < width - d) continue;
      wall += error;
      ++at_wall;
    }
    const double top = force * width * width / (8 * viscosity);
    std::printf("d = b/%d: speed of the layers at the plates %+.3f of g b²/8ν too high\n", across,
                wall / at_wall / top);
    report({fmt::format("plane Poiseuille flow from rest, d = b/{}: rms of u over g b²/8ν at t = 0.3 b²/ν", across),
            "Batchelor 1967", std::sqrt(square / count) / top, 0.05, "1", 0.4});
  }
}

}  // namespace drench::test
