// Stage flow_direction: backend against reference from identical input.

#include <gtest/gtest.h>

#include "pipeline/backend.hpp"
#include "stage_compare.hpp"

namespace drench::test {

TEST(flow_direction, agrees_with_the_reference) {
  compare_stage({.stage = Stage::flow_direction, .changes = "sample_flow_direction"});
}

TEST(flow_direction, is_gravity_away_from_solids) {
  const auto scene = with(with(wet_scene(), "  - sphere: {center: [0, -0.06, 0], radius: 0.05}\n", ""), "[0, -0.2, 0]",
                          "[0, -0.9, 0]");
  const auto setup = setup_from(scene);
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  backend->upload(setup.state);
  backend->run(Stage::porous_neighbors, {}, report);
  backend->run(Stage::flow_direction, {}, report);
  for (const Vec3& v : backend->download().sample_flow_direction) EXPECT_NEAR(v[1], -1 / 1.001, 1e-5);
}
}  // namespace drench::test
