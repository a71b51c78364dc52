// Dynamic bodies that cloth carries, stops and lifts: docs/theory/bodies.md, Reaction of cloth.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "ball_on_sheet.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// Mean vertical force of contact on the body and of the cloth on its pins over some steps, N.
struct Load {
  double contact = 0, pins = 0;
};
Load mean_load(SceneRun& run, int steps) {
  Load load;
  for (int k = 0; k < steps; ++k) {
    run.step();
    const HostState s = run.state();
    for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
      load.contact -= (s.node_contact_force[n][1] + s.node_friction_force[n][1]) / steps;
      load.pins += s.node_pin_force[n][1] / steps;
    }
  }
  return load;
}

}  // namespace

// The lightest ball has a third of the weight of the cloth; the heaviest has seven times as much.
TEST(carried_bodies, pins_carry_the_weight_of_a_ball_in_a_sheet) {
  for (const double density : {20.0, 400.0}) {
    SceneRun run(scene_of({.density = density,
                           .cloth = "pin: [{edges: true}]\n    damping: 6",
                           .top = "cloth_solver: {tolerance: 1.0e-3}\n",
                           .step = 0.004}));
    while (run.time() < 4) run.step();
    const Load load = mean_load(run, 50);
    const double weight = 9.81 * run.model().bodies[0].mass, all = weight + 9.81 * cloth_mass(run.model());
    const std::string ball = fmt::format("sphere of density {} at rest in a cloth with pinned edges: ", density);
    report({ball + "force of contact over the sphere's weight, distance from 1", "Newton",
            std::abs(load.contact / weight - 1), 0.01});
    report({ball + "force on the pins over the total weight, distance from 1", "Newton",
            std::abs(std::abs(load.pins) / all - 1), 0.01});
  }
}

TEST(carried_bodies, a_ball_that_hits_a_free_sheet_shares_its_momentum) {
  for (const double density : {20.0, 400.0}) {
    SceneRun run(scene_of({.density = density,
                           .cloth = "friction: 0.5\n    damping: 0",
                           .top = "gravity: [0, 0, 0]\ncloth_solver: {tolerance: 1.0e-3}\n"}));
    const Vec3 before = momentum_with_body(run.model(), run.initial());
    while (run.time() < 0.1) run.step();
    const Vec3 after = momentum_with_body(run.model(), run.state());
    double apart = 0;
    for (std::size_t a = 0; a < 3; ++a) apart = std::max(apart, std::abs(after[a] - before[a]) / std::abs(before[1]));
    report({fmt::format("sphere of density {} hits a free cloth at 0.5 m/s: relative change of the total momentum",
                        density),
            "conservation", apart, 0.01});
    EXPECT_LT(std::abs(run.state().body_velocity[0][1]), 0.499) << "it has not hit the sheet";
  }
}

}  // namespace drench::test
