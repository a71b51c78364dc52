// Stage emission: backend against reference from identical input, and its momentum.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "precision.hpp"
#include "stage_compare.hpp"
#include "states.hpp"

namespace drench::test {

TEST(emission, agrees_with_the_reference) { compare_stage({.stage = Stage::emission, .changes = "node_liquid"}); }

TEST(emission, new_particles_agree_with_the_reference) {
  compare_stage({.stage = Stage::emission,
                 .steps_before = 2,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       overfill(m, s, 8);
                       for (Vec3& x : s.fluid_position) x[1] += 0.2;  // room below the sheet
                     },
                 .changes = "fluid_id"});
}

TEST(emission, of_steep_fabric_agrees_with_the_reference) {
  // Only samples at the hem make particles.
  compare_stage(
      {.stage = Stage::emission,
       .scene =
           with(with(wet_scene(), "    thickness: 0.002\n",
                     "    thickness: 0.04\n    settle: 1\n    place: {rotate: {axis: [1, 0, 0], degrees: 75}}\n"),
                "hold_saturation: [{box: {min: [-0.2, -1, 0.12]", "hold_saturation: [{box: {min: [-0.2, -1, 0.03]"),
       .steps_before = 2,
       .prepare = [](const Model& m, HostState& s) { overfill(m, s, 50); },
       .changes = "fluid_id"});
}

TEST(emission, keeps_momentum_to_rounding) {
  // Of nodes that move differently, to liquid, to new particles and between layers. Whole quanta alone would leave
  // 4e-12.
  const auto setup = setup_from(with(wet_scene(), "    pin: [{edges: true}]\n", ""));
  const Model& m = setup.model;
  HostState s = setup.state;
  overfill(m, s, 8);
  for (std::size_t i = 0; i < s.fluid_position.size(); ++i)
    if (i % 2 == 0)
      s.fluid_position[i][1] += 0.2;  // room below the sheet
    else
      s.fluid_mass[i] -= s.fluid_mass[i] / 9;  // takes a part of what it is offered
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n)
    for (std::size_t a = 0; a < 3; ++a) s.node_velocity[n][a] = float(2 * noise(n, static_cast<int>(a)));
  const auto momentum = [&](const HostState& at, double& size) {
    Vec3 sum{0, 0, 0};
    const auto add = [&](double mass, const Vec3& v) {
      for (std::size_t a = 0; a < 3; ++a) {
        sum[a] += mass * v[a];
        size += mass * std::abs(v[a]);
      }
    };
    for (std::size_t i = 0; i < at.fluid_mass.size(); ++i)
      add(m.quantum * double(at.fluid_mass[i]), at.fluid_velocity[i]);
    for (std::size_t n = 0; n < at.node_liquid.size(); ++n)
      add(m.mesh.solid_mass[n] + m.quantum * double(at.node_liquid[n]), at.node_velocity[n]);
    return sum;
  };
  run_on_both(m, s, {Stage::neighbors, Stage::porous_neighbors, Stage::flow_direction, Stage::emission}, {0, 0, 0.002},
              [&](const Backend& backend, const StepReport&) {
                const HostState after = backend.download();
                EXPECT_GT(after.fluid_id.size(), s.fluid_id.size());
                double size = 0, unused = 0;
                const Vec3 before = momentum(s, size), now = momentum(after, unused);
                for (std::size_t a = 0; a < 3; ++a)
                  EXPECT_LE(std::abs(now[a] - before[a]), allowed(backend, 1e-12, 1e-6) * size) << a;
              });
}

TEST(emission, between_layers_without_room_for_a_particle_agrees_with_the_reference) {
  // A tight sheet below one half of the wet one, 1 and 2.5 spacings away: only the second leaves room.
  for (const double below : {0.02, 0.05}) {
    const std::string scene =
        with(wet_scene(), "bodies:\n",
             fmt::format(
                 "  - name: tight\n    mesh: {{grid: {{size: [0.13, 0.28], nodes: [7, 13]}}}}\n    place: {{position: "
                 "[-0.08, {}, 0]}}\n    pin: [{{edges: true}}]\nbodies:\n",
                 -below));
    const auto prepare = [](const Model& m, HostState& s) {
      overfill(m, s, 8);
      for (Vec3& x : s.fluid_position) x[1] += 0.2;  // room below the sheet
    };
    compare_stage(
        {.stage = Stage::emission, .scene = scene, .steps_before = 2, .prepare = prepare, .changes = "fluid_id"});
    const auto setup = setup_from(scene);
    HostState s = setup.state;
    prepare(setup.model, s);
    const std::size_t old = s.fluid_id.size();
    run_on_both(setup.model, s, {Stage::neighbors, Stage::porous_neighbors, Stage::flow_direction, Stage::emission},
                {0, 0, 0.002}, [&](const Backend& backend, const StepReport&) {
                  const HostState after = backend.download();
                  int covered = 0, open = 0;
                  for (std::size_t i = old; i < after.fluid_id.size(); ++i)
                    if (std::abs(after.fluid_position[i][2]) < 0.12)
                      ++(after.fluid_position[i][0] < -0.03 && after.fluid_position[i][0] > -0.13 ? covered : open);
                  EXPECT_GT(open, 0);
                  EXPECT_EQ(covered > 0, below > 0.03) << covered << " particles";
                });
  }
}

}  // namespace drench::test
