// What moves by keys and files displaces what its keys say: a piston of mesh files in a channel of water, and a jet
// whose flow rises, turns and stops.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include "mesh_sequence.hpp"
#include "piston_pool.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr double d = 0.01;   // m
constexpr double way = 0.1;  // m: of the piston
constexpr double fps = 20;

/// Of the piston at a time, m: it starts and stops gently, between 1 s and 2 s.
double pushed(double t) {
  const double s = std::clamp(t - 1, 0.0, 1.0);
  return way * s * s * (3 - 2 * s);
}

}  // namespace

TEST(keyed_motion, a_piston_of_mesh_files_displaces_the_water_that_it_sweeps) {
  const std::string files = write_boxes("piston", 50, {0.05, 0.2, 0.06}, [](int k, const Eigen::Vector3d& x) {
    return Eigen::Vector3d(x + Eigen::Vector3d(-0.05 + pushed(k / fps), 0.15, 0));
  });
  double inside = 0;
  const PistonPool pool;
  const double swept = pool.floor_taken(files, fps, [&](const SceneRun& run, const HostState& s) {
    for (const Vec3& x : s.fluid_position) inside = std::max(inside, pushed(run.time()) - x[0]);
  }) / pool.width;
  std::printf("the water is %.5f m shorter, the piston came %.5f m; deepest %.2e m\n", swept, way, inside);
  report({"a piston of mesh files: displaced volume, from the centre of mass", "swept volume",
          std::abs(swept / way - 1), 0.02});
  report({"a piston of mesh files: deepest penetration of a particle over d", "none inside",
          std::max(0.0, inside) / pool.spacing, 1e-5});
}

/// A bellows: a closed cloth, all of its nodes pinned to files, whose top rises in a pool. Where it stands over its
/// floor, and before and after, water rests some 0.2 spacings nearer to a sheet or farther from it: so the way is
/// twelve spacings long.
namespace bellows {

constexpr double fine = 0.02 / 3, side = 0.16 / 3;                     // m: spacing; half the pool's side
constexpr double half = 0.02, base = 0.02, tall = 0.03, grown = 0.08;  // m: of the bellows; its top rises by the last
constexpr std::array<int, 3> cells{6, 16, 6};                          // none wider than a spacing when it has grown

double risen(double t) {
  const double s = std::clamp(t - 2, 0.0, 1.0);
  return grown * s * s * (3 - 2 * s);
}

/// As the files have it: straight from one to the next.
double top_at(double t) {
  const double k = std::floor(t * fps);
  return base + tall + std::lerp(risen(k / fps), risen((k + 1) / fps), t * fps - k);
}

void write_file(const std::filesystem::path& path, double rise) {
  std::ofstream out(path);
  std::map<std::array<int, 3>, int> number;
  const auto node = [&](const std::array<int, 3>& p) {
    const auto [at, fresh] = number.try_emplace(p, static_cast<int>(number.size()) + 1);
    if (fresh)
      out << fmt::format("v {:.9g} {:.9g} {:.9g}\n", 2 * half * (double(p[0]) / cells[0] - 0.5),
                         base + (tall + rise) * p[1] / cells[1], 2 * half * (double(p[2]) / cells[2] - 0.5));
    return at->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int end : {0, cells[axis]})
      for (int i = 0; i < cells[(axis + 1) % 3]; ++i)
        for (int j = 0; j < cells[(axis + 2) % 3]; ++j) {
          const auto at = [&](int first, int second) {
            std::array<int, 3> p{};
            p[axis] = end;
            p[(axis + 1) % 3] = first;
            p[(axis + 2) % 3] = second;
            return node(p);
          };
          const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d4 = at(i, j + 1);
          out << (end > 0 ? fmt::format("f {0} {1} {2}\nf {0} {2} {3}\n", a, b, c, d4)
                          : fmt::format("f {0} {2} {1}\nf {0} {3} {2}\n", a, b, c, d4));
        }
}

/// The moment of the water about the floor grows as water goes from where the bellows is now to the top of the pool:
/// d(volume · mean) = ∫ (level − y) dV, the level rising with V.
double moment(double volume) {
  constexpr double area = 4 * side * side, slice = 4 * half * half * grown / 1000;
  double sum = 0, level = (volume + 4 * half * half * tall) / area;
  for (int k = 0; k < 1000; ++k) {
    sum += (level + 0.5 * slice / area - base - tall - (k + 0.5) * grown / 1000) * slice;
    level += slice / area;
  }
  return sum;
}

}  // namespace bellows

TEST(keyed_motion, a_cloth_pinned_to_files_that_change_its_shape_displaces_its_volume) {
  using namespace bellows;
  const auto files = own_file("bellows");
  std::filesystem::create_directories(files);
  for (int k = 0; k < 65; ++k) write_file(files / fmt::format("b_{:04d}.obj", k), risen(k / fps));
  SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 10, mode: cfl}}
domain: {{min: [-0.3, -0.1, -0.3], max: [0.3, 1, 0.3]}}
output: {{every: 0}}
fluid:
  spacing: {0}
  viscosity: 2.0e-3
  sources:
    - block: {{min: [-{1}, 0, -{1}], max: [{1}, {5}, {1}]}}
    - block: {{min: [-{1}, {5}, -{1}], max: [-{6}, 0.16, {1}]}}
    - block: {{min: [{6}, {5}, -{1}], max: [{1}, 0.16, {1}]}}
    - block: {{min: [-{6}, {5}, -{1}], max: [{6}, 0.16, -{6}]}}
    - block: {{min: [-{6}, {5}, {6}], max: [{6}, 0.16, {1}]}}
    - block: {{min: [-{6}, {7}, -{6}], max: [{6}, 0.16, {6}]}}
cloth:
  - mesh: {{file: "{2}"}}
    pin: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, sequence: "{3}", fps: {4}}}]
bodies:
  - box: {{min: [-{1}, 0, -{1}], max: [{1}, 0.6, {1}], inside: true}}
)",
                           fine, side, (files / "b_0000.obj").string(), (files / "b_{:04d}.obj").string(), fps,
                           base - fine, half + fine, base + tall + fine));
  const double volume = run.initial().fluid_count() * fine * fine * fine;
  double before = 0, after = 0;
  double inside = 0;
  int samples_before = 0, samples_after = 0;
  while (run.time() < 5) {
    run.step();
    const HostState s = run.state();
    const double top = top_at(run.time());
    for (const Vec3& x : s.fluid_position)
      inside = std::max(inside, std::min({half - std::abs(x[0]), half - std::abs(x[2]), x[1] - base, top - x[1]}));
    if (run.time() > 1.2 && run.time() < 2) before += mean_height(s), ++samples_before;
    if (run.time() > 4) after += mean_height(s), ++samples_after;
  }
  before /= samples_before;
  after /= samples_after;
  const double measured = volume * (after - before), expected = moment(volume);
  std::printf("centre of mass %.5f → %.5f m, moment grew by %.4e m⁴, expected %.4e; deepest inside %.2e m\n", before,
              after, measured, expected, inside);
  report({"a closed cloth pinned to files that change its shape: moment of the water that it displaces",
          "its volume in the files", std::abs(measured / expected - 1), 0.02, "1", Reached{0.0326, 0.0326, 0.0297},
          "Rounding decides how the layers of particles settle before and after: it makes the error 0 to 0.03."});
  report({"a closed cloth pinned to files that change its shape: deepest penetration of a particle over d",
          "none inside", inside / fine, 1e-5});
}

TEST(keyed_motion, a_jet_with_keys_carries_the_integral_of_its_flow) {
  double worst = 0;
  for (const char* between : {"linear", "smooth", "step"}) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.0037, end: 1, mode: cfl}}
gravity: [0, 0, 0]
domain: {{min: [-1, -1, -1], max: [2, 2, 1]}}
fluid:
  spacing: {}
  sources: [{{jet: {{center: [0, 0, 0], radius: 0.03, start: 0.013,
    velocity: {{keys: [[0, [0, 0, 0]], [0.1, [2, 0, 0]], [0.2, [1, 1, 0]], [0.25, [0, 0, 0]], [0.35, [0, 0, 0]],
        [0.4, [0, 1, 0]]],
    interpolation: {}}}}}}}]
)",
                             d, between));
    const Keyed<double> speed = run.model().jets[0].speed;
    while (run.time() < 0.5) {
      run.step();
      const double expected =
          1000 * std::numbers::pi * 0.03 * 0.03 * speed.integral(0.013, std::max(0.013, run.time()));
      worst = std::max(worst,
                       std::abs(kilograms(run.model(), run.state().supplied) - expected) / run.model().particle_mass);
    }
    EXPECT_GT(run.state().fluid_count(), 100);
  }
  report({"emitters with keyframes: largest difference of the mass from ρ A ∫v over a particle's mass", "ρ A ∫v dt",
          worst, 0.5001});
}

}  // namespace drench::test
