// Stage bodies: backend against reference from identical input, and rigidity of the rotation.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

/// A scene with a spinning tetrahedron, written beside the system's other temporary files.
std::string spinning_scene() {
  const auto path = std::filesystem::temp_directory_path() / "drench_bodies_test.obj";
  std::ofstream(path) << "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  return "drench: 1\ntime: {step: 0.01, end: 1}\nfluid:\n  spacing: 0.02\n  sources:\n    - block: {min: [0.3, 0, 0], "
         "max: [0.4, "
         "0.1, 0.1]}\nbodies:\n  - mesh: {file: " +
         path.string() + ", spin: {axis: [0, 1, 1], degrees_per_second: 180}}\n";
}

}  // namespace

TEST(bodies, agrees_with_the_reference) {
  compare_stage({.stage = Stage::bodies, .scene = spinning_scene(), .steps_before = 3, .changes = "boundary_position"});
}

TEST(bodies, keeps_distances_from_the_centre_over_a_whole_turn) {
  const auto setup = setup_from(spinning_scene());
  const auto backend = make_kokkos_backend(setup.model);
  backend->upload(setup.state);
  StepReport report;
  backend->run(Stage::bodies, {0, 1.99, 0.01}, report);  // t = 2 s: one turn
  const HostState s = backend->download();
  for (std::size_t b = 0; b < s.boundary_position.size(); ++b)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(s.boundary_position[b][k], setup.state.boundary_position[b][k], 1e-6);
}

}  // namespace drench::test
