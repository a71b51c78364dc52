// Valid scenes at the limits of their keys run three steps: each goes on, or ends with a reason. DRENCH_FUZZ_SEED and
// DRENCH_FUZZ_COUNT repeat or lengthen the hunt, DRENCH_FUZZ_SECONDS ends it; tools/dev/fuzz runs it under the
// sanitizers.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/failure.hpp"
#include "pipeline/pipeline.hpp"
#include "restart_scenes.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "valid_scenes.hpp"

namespace drench::testing {
namespace {

constexpr int steps = 3;

/// Nothing but the liquid moves, so that what a changed key sets in motion is alone.
constexpr const char* still_scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.2, -0.2, -0.2], max: [0.2, 0.3, 0.2]}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.04, 0.1, -0.04], max: [0.04, 0.16, 0.04]}}]}
cloth: [{mesh: {file: sheet.obj}, place: {position: [0, 0.08, 0]}, dynamics: false}]
bodies:
  - sphere: {center: [0, 0, 0], radius: 0.06}
  - mesh: {file: ball.obj, scale: 0.05, position: [0.1, 0, 0]}
)";

/// What is hinged, hangs on springs, is squeezed, filmed, rained on, drained and scaled.
constexpr const char* hinged_scene = R"(drench: 1
time: {step: 0.002, end: 1}
domain: {min: [-0.2, -0.2, -0.2], max: [0.2, 0.3, 0.2]}
fluid:
  spacing: 0.02
  sources:
    - block: {min: [-0.04, 0.1, -0.04], max: [0.04, 0.16, 0.04]}
    - rain: {center: [0, 0.25, 0], size: [0.1, 0.1], rate: 50000, diameter: 0.003}
    - spray: {center: [0, 0.2, 0.05], direction: [1, 0, 0], half_angle: 40, speed: 2, flow: 20,
          motion: {velocity: [0, 0, 1]}}
  drains: [{sphere: {center: [0, -0.1, 0], radius: 0.05}}]
cloth:
  - mesh: {grid: {size: [0.1, 0.1], nodes: [5, 5]}}
    place: {position: [0, 0.08, 0]}
    pin: [{corners: true, stiffness: 100, release: 0.004}]
    initial_saturation: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}, value: 1}]
    porous: {diffusivity: 1.0e-4, diffusion: degenerate, drainage_height: 2, drainage_exponent: 1.5,
             large_pores: 0.5, large_pore_height: 0.1, pore_narrowing: 2, hygral_expansion: 0.05,
             film: 1.0e-4, film_viscosity: 1.0e-5, compressibility: 0.3}
bodies:
  - name: lid
    box: {min: [-0.05, 0.01, -0.05], max: [0.05, 0.03, 0.05], dynamic: true, density: 600}
    place: {scale: [1, 1, 1.2], rotate: {axis: [0, 1, 0], degrees: 10}}
  - sphere: {center: [0, -0.02, 0], radius: 0.02}
    place: {scale: [2, 1, 1]}
joints:
  - hinge: {body: lid, point: [0.05, 0.02, 0], axis: [0, 0, 1], limits: [-60, 60],
        motor: {degrees_per_second: 50, torque: 0.1}}
)";

void write_meshes(const std::filesystem::path& folder) {
  test::write_text(folder / "sheet.obj",
                   "v -0.05 0 -0.05\nv 0.05 0 -0.05\nv 0.05 0 0.05\nv -0.05 0 0.05\nv 0 0.01 0\n"
                   "f 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  test::write_text(folder / "ball.obj",
                   "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
                   "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n");
}

/// Liquid that jets let out in so many of the scene's steps, in particles.
double particles_of_jets(const Model& m) {
  const double until = steps * m.scene.time.step;
  double count = 0;
  for (const Jet& jet : m.jets)
    count += jet.has_keys() ? jet.out(until) / jet.advance : std::max(0.0, until - jet.scene.start) / jet.interval;
  return count;
}

/// "refused", "ended" with a reason, "ran", or "large": more than a test can have.
std::string outcome_of(const std::string& text, const std::string& path) {
  MemoryBudget small;
  small.host = 128.0 * (1 << 20);
  small.arrays = [](const SetupSize& size) { return kokkos_array_bytes(size, 4, false); };
  try {
    const Setup setup = build(parse_scene(text, path), small);
    constexpr double most = 4000;
    if (static_cast<double>(setup.state.fluid_count()) + particles_of_jets(setup.model) > most ||
        setup.model.mesh.nodes() + setup.model.boundary.count() + setup.model.samples.count() > 5 * most)
      return "large";
    const std::unique_ptr<Backend> backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int step = 0; step < steps; ++step) pipeline.step(1);
    const HostState state = backend->download();
    EXPECT_EQ(state.fluid_position.size(), state.fluid_mass.size());
    return "ran";
  } catch (const SceneError&) {
    return "refused";
  } catch (const SetupError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return "refused";
  } catch (const RunFailure& failure) {
    EXPECT_NE(std::string(failure.what()), "");
    return "ended";
  }
}

double number_of(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text ? std::stod(text) : otherwise;
}

TEST(BoundaryValues, OfEveryKeyRunThreeSteps) {
  const auto seed = static_cast<std::uint64_t>(number_of("DRENCH_FUZZ_SEED", 1));
  const double wanted = number_of("DRENCH_FUZZ_COUNT", 150), limit = number_of("DRENCH_FUZZ_SECONDS", 1e9);
  const test::TempFolder here;
  const char* kept = std::getenv("DRENCH_FUZZ_SCENE");  // where the scene stands that a crash leaves
  const std::filesystem::path file = kept ? std::filesystem::path(kept) : here.path() / "scene.yaml";
  write_meshes(here.path());
  const std::vector<std::string> scenes{still_scene,       test::liquid_scene, test::porous_scene, test::cloth_scene,
                                        test::keyed_scene, test::filter_scene, hinged_scene};
  ValidScenes valid(seed);
  std::map<std::string, int> counts;
  double slowest = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto since = [](auto from) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  };
  for (int run = 0; counts["ran"] < wanted && since(begin) < limit; ++run) {
    const std::string text = valid.next(scenes[static_cast<std::size_t>(run) % scenes.size()]);
    test::write_text(file, text);
    SCOPED_TRACE(fmt::format("seed {}, run {}:\n{}", seed, run, text));
    const auto start = std::chrono::steady_clock::now();
    std::string outcome;
    ASSERT_NO_THROW(outcome = outcome_of(text, here.path() / "valid.yaml"));
    ++counts[outcome];
    if (const double seconds = since(start); seconds > slowest) {
      slowest = seconds;
      if (kept) std::printf("%.2f s, run %d, %s\n", seconds, run, outcome.c_str());
    }
  }
  EXPECT_GT(counts["ran"], 0);
  std::printf("%d scenes ran, %d ended with a reason, %d were refused, %d are too large; %.2f s the slowest\n",
              counts["ran"], counts["ended"], counts["refused"], counts["large"], slowest);
}

}  // namespace
}  // namespace drench::testing
