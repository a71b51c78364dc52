// Bodies that float and sink: Archimedes' draught of spheres and boxes, the first acceleration of a heavy sphere, which
// has to set the water around it in motion too, and the angles at which boxes float.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double pi = std::numbers::pi, d = 0.02;  // m

/// fluid.wall_pressure, and what rows say of it.
struct Walls {
  const char *pressure, *words;
};
constexpr Walls mirrored{"mirrored", ", mirrored walls"}, extrapolated{"extrapolated", ""};

/// A box of water, 2 half × depth × 2 half, with a body in it.
std::string pool(double half, double depth, double viscosity, double tolerance, const std::string& body,
                 const Walls& walls = extrapolated) {
  return fmt::format(R"(drench: 1
time: {{step: 0.002, end: 10, mode: cfl}}
domain: {{min: [-1, -0.5, -1], max: [1, 2, 1]}}
output: {{every: 0}}
fluid:
  spacing: {0}
  viscosity: {1}
  wall_pressure: {6}
  solver: {{density_error: {2}, divergence_error: {2}, max_iterations: 1000}}
  sources: [{{block: {{min: [-{3}, 0, -{3}], max: [{3}, {4}, {3}]}}}}]
bodies:
  - box: {{min: [-{3}, 0, -{3}], max: [{3}, 1, {3}], inside: true}}
  - {5}
)",
                     d, viscosity, tolerance, half, depth, body, walls.pressure);
}

/// Horizontal section of a body, m², at the height z over its centre.
struct Section {
  double half_height;  // m
  double radius;       // m: a sphere's; 0: a box
  double box_area;     // m²
  double at(double z) const { return radius > 0 ? pi * (radius * radius - z * z) : box_area; }
};

/// The level of a pool, from the height of its centre of mass: liquid fills it up to the level but for what of the body
/// is below. (From the volume alone it would be wrong by what the layers along the pool's walls have settled.)
double level_of(const HostState& s, double area, const Section& body) {
  double mean = 0;
  for (const Vec3& x : s.fluid_position) mean += x[1];
  mean /= s.fluid_count();
  const double volume = s.fluid_count() * d * d * d, center = s.body_position[1][1];
  double level = volume / area;
  constexpr int slices = 400;
  for (int sweep = 0; sweep < 60; ++sweep) {
    double moment = 0;  // m⁴: of what is immersed
    for (int k = 0; k < slices; ++k) {
      const double dz = 2 * body.half_height / slices, z = -body.half_height + (k + 0.5) * dz;
      if (center + z < level) moment += (center + z) * body.at(z) * dz;
    }
    level = std::sqrt(2 * (volume * mean + moment) / area);
  }
  return level;
}

/// Mean draught (m) over the second half of `duration`.
double mean_draught(SceneRun& run, double half, const Section& body, double duration) {
  double sum = 0, next = 0.5 * duration;
  int count = 0;
  while (run.time() < duration) {
    run.step();
    if (run.time() < next) continue;
    next += duration / 80;
    const HostState s = run.state();
    sum += level_of(s, 4 * half * half, body) - (s.body_position[1][1] - body.half_height);
    ++count;
  }
  return sum / count;
}

TEST(buoyancy, a_sphere_of_half_the_density_is_half_immersed) {
  const double half = 0.2, depth = 0.3, R = 0.1;
  const std::string ball =
      fmt::format("sphere: {{center: [0, {}, 0], radius: {}, dynamic: true, density: 500}}", depth, R);
  for (const Walls& walls : {extrapolated, mirrored}) {
    SceneRun run(pool(half, depth, 0.01, 5e-4, ball, walls));
    const double draught = mean_draught(run, half, {R, R, 0}, 1.2);
    report({fmt::format("floating sphere of density ½, d = R/5{}: draught over R, distance from 1", walls.words),
            "Archimedes", std::abs(draught / R - 1), 0.05});
  }
}

TEST(buoyancy, a_box_floats_at_its_share_of_the_density) {
  const double half = 0.2, depth = 0.3, height = 0.16;
  const std::string box =
      fmt::format("box: {{min: [-0.1, {}, -0.1], max: [0.1, {}, 0.1], dynamic: true, density: 500}}",
                  depth - 0.5 * height, depth + 0.5 * height);
  SceneRun run(pool(half, depth, 0.01, 5e-4, box));
  const double draught = mean_draught(run, half, {0.5 * height, 0, 0.04}, 1.2);
  report({"floating box of density ½, 10 × 8 × 10 d: draught over half its height, distance from 1", "Archimedes",
          std::abs(draught / (0.5 * height) - 1), 0.05});
}

/// Draught of a floating sphere over its radius, h²(3 − h)/4 = the density's ratio.
double sphere_draught(double ratio) {
  double low = 0, high = 2;
  while (high - low > 1e-9) {
    const double h = 0.5 * (low + high);
    (h * h * (3 - h) < 4 * ratio ? low : high) = h;
  }
  return low;
}

// Both begin half immersed, so that they have to find their draught: the light ones rise, the heavy ones sink.
void find_draught(double ratio) {
  const double half = 0.2, depth = 0.2, R = 0.1, height = 0.16, duration = 1.6;
  const std::string dynamic = fmt::format("dynamic: true, density: {}", 1000 * ratio);
  SceneRun sphere(
      pool(half, depth, 0.002, 5e-4, fmt::format("sphere: {{center: [0, {}, 0], radius: {}, {}}}", depth, R, dynamic)));
  SceneRun box(pool(half, depth, 0.002, 5e-4,
                    fmt::format("box: {{min: [-0.1, {}, -0.1], max: [0.1, {}, 0.1], {}}}", depth - 0.5 * height,
                                depth + 0.5 * height, dynamic)));
  const std::string over = ": draught over Archimedes', distance from 1";
  report({fmt::format("floating sphere of density {}, d = R/5{}", ratio, over), "Archimedes",
          std::abs(mean_draught(sphere, half, {R, R, 0}, duration) / (R * sphere_draught(ratio)) - 1), 0.05});
  report({fmt::format("floating box of density {}, 10 × 8 × 10 d{}", ratio, over), "Archimedes",
          std::abs(mean_draught(box, half, {0.5 * height, 0, 0.04}, duration) / (ratio * height) - 1), 0.05});
}

TEST(buoyancy, light_and_heavy_bodies_find_their_draught) {
  for (const double ratio : {0.25, 0.75}) find_draught(ratio);
}

/// How far a box has turned about z, rad: the slope of its x axis.
double slope(const HostState& s) {
  const auto& [w, x, y, z] = s.body_orientation[1];
  return std::asin(2 * (x * y + w * z));
}

/// A box of a half-width and half-height (m) and of 16 d along z floats, upright at first, is pushed, and comes to
/// rest.
struct Tilt {
  double largest = 0, mean = 0, swing = 0;  // rad; mean and largest distance from it over the last 0.75 s
};
Tilt push(double half_width, double half_height, double ratio, double turn, double duration) {
  const double half = 0.2, depth = 0.2, bottom = depth - 2 * half_height * ratio;
  SceneRun run(pool(half, depth, 0.002, 5e-4,
                    fmt::format("box: {{min: [-{0}, {1}, -0.16], max: [{0}, {2}, 0.16], dynamic: true, density: {3}}}",
                                half_width, bottom, bottom + 2 * half_height, 1000 * ratio)));
  HostState start = run.initial();
  start.body_angular_velocity[1] = {0, 0, turn};
  run.restart(start);
  Tilt tilt;
  std::vector<double> slopes;
  while (run.time() < duration) {
    run.step();
    const double now = slope(run.state());
    tilt.largest = std::max(tilt.largest, now);
    if (run.time() > duration - 0.75) slopes.push_back(now);
  }
  for (const double one : slopes) tilt.mean += one / double(slopes.size());
  for (const double one : slopes) tilt.swing = std::max(tilt.swing, std::abs(one - tilt.mean));
  const double degrees = 180 / pi;
  std::printf("box of %g x %g m, density %g: turned %.1f degrees, at rest %.2f +- %.2f\n", 2 * half_width,
              2 * half_height, ratio, tilt.largest * degrees, tilt.mean * degrees, tilt.swing * degrees);
  return tilt;
}

// Erdős, Schibler and Herndon 1992: a long square beam floats level up to a density of 0.211. Up to 9/32 it floats at
// tan²θ = 12 s (1 − s) − 2, and from there to 23/32 on an edge.
TEST(buoyancy, beams_float_at_the_angle_of_their_section) {
  const Tilt half = push(0.08, 0.08, 0.5, 2, 2.5), quarter = push(0.08, 0.08, 0.25, 2, 2.5);
  report({"beam, 8 × 8 × 16 d, pushed while level, density ½: angle at rest over 45°, distance from 1",
          "Erdős et al. 1992", std::abs(half.mean / (pi / 4) - 1), 0.05});
  report({"beam, 8 × 8 × 16 d, pushed while level, density ¼: angle at rest over arctan ½, distance from 1",
          "Erdős et al. 1992", std::abs(quarter.mean / std::atan(0.5) - 1), 0.05, "1", Reached{0.152, 0.152, 0.139},
          "The lever arm that tilts it further is at most 0.8 % of its width, a sixteenth of a spacing."});
}

TEST(buoyancy, a_flat_box_rights_itself) {
  const Tilt flat = push(0.12, 0.04, 0.5, 8, 2.5);
  EXPECT_GT(flat.largest, 0.1) << "rad: the push has hardly tilted it";
  report({"box, 12 × 4 × 16 d, density ½, pushed while level: mean angle after 2 s over the largest", "rights itself",
          std::abs(flat.mean) / flat.largest, 0.05});
}

/// Mean vertical acceleration over the first 0.02 s from a state, m/s². Later the drag of the rough sphere is felt.
double first_acceleration(SceneRun& run, const HostState& start) {
  run.restart(start);
  while (run.time() < start.time + 0.02 - 1e-9) run.step(start.time + 0.02 - run.time());
  return (run.state().body_velocity[1][1] - start.body_velocity[1][1]) / 0.02;
}

TEST(buoyancy, spheres_set_out_with_their_added_mass) {
  const double half = 0.28, R = 0.08;
  const auto scene = [&](double density, double viscosity) {
    return pool(half, 2 * half, viscosity, viscosity > 1e-4 ? 2e-4 : 5e-5,
                fmt::format("sphere: {{center: [0, 0.28, 0], radius: {}, dynamic: true, density: {}}}", R, density));
  };
  // Water and a sphere of its own density come to rest; then the sphere becomes a heavy or a light one, and the water
  // inviscid: with the viscosity that calms it, the boundary layer would hold the sphere back at once (Basset). The box
  // is 3.5 radii wide to each side; in a concentric shell of that radius the added mass is 0.535, not 0.5 of the
  // water's.
  SceneRun rest(scene(1000, 0.01));
  while (rest.time() < 0.14) rest.step();
  const HostState start = rest.state();
  // What is left of the settling's own motion goes on in all three: the sphere that has the water's density shows it.
  const auto acceleration = [&](double density) {
    SceneRun run(scene(density, 1e-6));
    return first_acceleration(run, start);
  };
  const double neutral = acceleration(1000);
  for (const double density : {2000.0, 100.0}) {
    const double theory = -9.81 * (density - 1000) / (density + 500);
    report(
        {fmt::format("sphere of density {} in deep water, d = R/4: first acceleration, relative error", density / 1000),
         "(ρs − ρ) g/(ρs + ½ ρ)", std::abs((acceleration(density) - neutral) / theory - 1), 0.1});
  }
}

}  // namespace
}  // namespace drench::test
