// A jet carries exactly what its nozzle says and leaves it without a burst.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <utility>
#include <vector>

#include "paths.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double spacing = 0.01, density = 1000;  // m, kg/m³

struct Jet {
  double mass = 0;     // largest |supplied − ρ A v t| over a particle's mass
  double crowded = 0;  // largest density ratio − 1 of particles less than 0.1 m from the nozzle
  double speed = 0;    // largest ||v| / |v0| − 1| in free flight without gravity
};

/// A mouth in the y-z plane that emits along x, in a scene file and as an area, m².
struct Mouth {
  std::string name, source;
  double area;
  double factor = 1;  // the speed of its liquid over that which the flow has
};

Mouth disc(double radius, double speed) {
  return {fmt::format("radius {:.1f} d", radius / spacing),
          fmt::format("jet: {{center: [0, 0, 0], radius: {}, velocity: [{}, 0, 0]", radius, speed),
          std::numbers::pi * radius * radius};
}

Mouth rectangle(double across, double up, double speed, const std::string& motion) {
  return {fmt::format("{:.1f} d by {:.1f} d{}", across / spacing, up / spacing, motion.empty() ? "" : ", moving"),
          fmt::format("jet: {{center: [0, 0, 0], size: [{}, {}], velocity: [{}, 0, 0]{}", across, up, speed, motion),
          across * up};
}

/// A triangle with legs of these lengths.
Mouth faces(double across, double up, double speed) {
  const std::string file = own_file("mouth.obj");
  std::ofstream(file) << fmt::format("v 0 0 0\nv 0 {} 0\nv 0 0 {}\nf 1 2 3\n", up, across);
  return {fmt::format("a mesh of {:.1f} d by {:.1f} d", across / spacing, up / spacing),
          fmt::format("mesh_jet: {{file: {}, speed: {}", file, speed), 0.5 * across * up, 1.05};
}

/// A jet without gravity from 0.013 s to `end`, for half a second. `moving`: the speed that its nozzle adds across x.
Jet pour(const Mouth& mouth, double speed, double end, double moving = 0) {
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.0037, end: 1, mode: cfl}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [5, 3, 1]}}
fluid:
  spacing: {}
  sources: [{{{}, start: 0.013, end: {}}}}}]
)",
                           spacing, mouth.source, end));
  Jet jet;
  const double flow = density * mouth.area * speed;
  while (run.time() < 0.5) {
    run.step();
    const HostState s = run.state();
    const double expected = flow * std::clamp(run.time() - 0.013, 0.0, end - 0.013);
    jet.mass = std::max(jet.mass, std::fabs(kilograms(run.model(), s.supplied) - expected) / run.model().particle_mass);
    for (std::size_t i = 0; i < s.fluid_position.size(); ++i) {
      const Vec3& v = s.fluid_velocity[i];
      jet.speed =
          std::max(jet.speed, std::fabs(std::hypot(v[0], v[1], v[2]) / std::hypot(mouth.factor * speed, moving) - 1));
      if (s.fluid_position[i][0] < 0.1) jet.crowded = std::max(jet.crowded, s.fluid_density_ratio[i] - 1);
    }
  }
  std::printf("%s, %.1f m/s: mass %.3f particles, density ratio 1 %+.4f, speed %.4f\n", mouth.name.c_str(), speed,
              jet.mass, jet.crowded, jet.speed);
  return jet;
}

}  // namespace

TEST(jet, carries_its_mass_and_does_not_burst) {
  Jet worst;
  for (const double speed : {0.5, 3.0}) {
    std::vector<std::pair<Mouth, double>> mouths;
    for (const double radius : {0.5, 1.7, 4.5}) mouths.emplace_back(disc(radius * spacing, speed), 0);
    for (const auto& [across, up] : std::vector<std::pair<double, double>>{{1, 8}, {5.4, 2.3}})
      mouths.emplace_back(rectangle(across * spacing, up * spacing, speed, ""), 0);
    mouths.emplace_back(rectangle(5 * spacing, 4 * spacing, speed, ", motion: {velocity: [0, 2, 0]}"), 2);
    mouths.emplace_back(faces(0.09, 0.07, speed), 0);
    for (const auto& [mouth, moving] : mouths) {
      const Jet jet = pour(mouth, speed, speed > 1 ? 0.3 : 10.0, moving);
      worst = {std::max(worst.mass, jet.mass), std::max(worst.crowded, jet.crowded), std::max(worst.speed, jet.speed)};
    }
  }
  report({"emitters: largest difference of the mass from ρ A v t over a particle's mass", "ρ A v t", worst.mass, 1});
  report({"emitters: largest density ratio near the nozzle, − 1", "no burst", worst.crowded, 0.05});
  report({"emitters: largest change of the speed in free flight over the speed", "no burst", worst.speed, 0.02});
}

}  // namespace drench::test
