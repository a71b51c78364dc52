// Stage pressure: backend against reference from identical input.

#include <gtest/gtest.h>

#include "scene/eigen_vec.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {

TEST(pressure, agrees_with_the_reference) {
  compare_stage_with_every_kernel({.stage = Stage::pressure, .steps_before = 40, .changes = "fluid_velocity"});
}

TEST(pressure, of_crowded_and_light_particles_agrees_with_the_reference) {
  // After 41 steps: after 40, with `cubic`, the cloth's residual is so near its goal at a check that single and double
  // precision stop ten iterations apart.
  compare_stage_with_every_kernel(
      {.stage = Stage::pressure, .steps_before = 41, .prepare = crowd, .changes = "fluid_velocity"});
}

TEST(pressure, of_particles_that_touch_the_sheet_agrees_with_the_reference) {
  // Every fourth that has the sheet within h comes to 0.02 to 0.18 d from it, the lists' side kept; some touch, some do not.
  const auto lower = [](const Model& m, HostState& s) {
    int touching = 0, thin = 0;
    for (std::size_t i = 0; i < s.fluid_position.size(); i += 4) {
      const NearestSample sample = nearest_sample(m, s, s.fluid_position[i], m.support);
      if (!sample.found) continue;
      const Eigen::Vector3d x = to_eigen(s.fluid_position[i]), normal = to_eigen(sample.normal);
      const double height = (x - to_eigen(sample.place)).dot(normal), share = 0.02 + 0.16 * double(i % 16) / 12;
      s.fluid_position[i] = to_vec3(x + ((height < 0 ? -share : share) * m.spacing - height) * normal);
      touching += share < 0.1 ? 1 : 0;
      thin += s.fluid_density_ratio[i] < 1 ? 1 : 0;
    }
    EXPECT_GT(touching, 5);
    EXPECT_GT(thin, 5) << "only where δ < 1 it makes a difference";
  };
  compare_stage({.stage = Stage::pressure, .steps_before = 40, .prepare = lower, .changes = "fluid_velocity"});
}

TEST(pressure, with_cloth_by_xpbd_agrees_with_the_reference) {
  compare_stage({.stage = Stage::pressure,
                 .scene = with(wet_scene(), "cloth:\n", "cloth_solver: {method: xpbd}\ncloth:\n"),
                 .steps_before = 40,
                 .changes = "fluid_velocity"});
}

}  // namespace drench::test
