// energy.csv: what a state holds, and what a run makes of it. Sums of the parts against closed forms and against the
// watch of the tests for stability, which has laws of its own.

#include "output/energy.hpp"

#include <gtest/gtest.h>

#include "commands_fixture.hpp"
#include "output_example.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "support/watch.hpp"

namespace drench::test {
namespace {

TEST(Energy, OfLiquidAndWetNodes) {
  Example e;
  e.model.scene.gravity = {0, -10, 0};
  e.model.mesh.solid_mass = {1, 2, 3};
  const Energies energy = energies_of(e.model, e.state);
  // 0.8, 0.1 and 0.8 kg at 1.5 m above the floor; the first moves with (1, 2, 3) m/s, the third with 1 m/s
  EXPECT_DOUBLE_EQ(energy.liquid_kinetic, 0.5 * 0.8 * 14 + 0.5 * 0.8);
  EXPECT_DOUBLE_EQ(energy.liquid_potential, 1.7 * 10 * 1.5);
  // nodes of 1, 2 and 3 kg at 1 m hold 0.2, 0.1 and 0 kg; the second moves with 2 m/s
  EXPECT_DOUBLE_EQ(energy.cloth_kinetic, 0.5 * 2.1 * 4);
  EXPECT_DOUBLE_EQ(energy.cloth_potential, 6.3 * 10 * 1);
  EXPECT_EQ(energy.stretch + energy.bend + energy.body_kinetic + energy.body_potential, 0);
  EXPECT_DOUBLE_EQ(energy.total(),
                   energy.liquid_kinetic + energy.liquid_potential + energy.cloth_kinetic + energy.cloth_potential);
}

TEST(Energy, TheLevelIsTheLowestCornerWhateverTheDirectionOfGravity) {
  Example e;
  e.model.mesh.solid_mass = {0, 0, 0};
  e.state.node_liquid = {0, 0, 0};
  e.model.scene.gravity = {10, 0, 0};
  EXPECT_DOUBLE_EQ(energies_of(e.model, e.state).liquid_potential, 10 * (0.8 * 1 + 0.1 * 0.9 + 0.8 * 0.8));
  e.model.scene.gravity = {0, 0, 0};
  EXPECT_EQ(energies_of(e.model, e.state).liquid_potential, 0);
  e.model.scene.field = {true, {0, 0.5, 0}, {2, 3, 4}};
  EXPECT_DOUBLE_EQ(energies_of(e.model, e.state).liquid_potential, 0.5 * 4 * (0.1 * 0.01 + 0.8 * 0.04));
}

constexpr const char* sheet_and_ball = R"(drench: 1
time: {step: 0.002, end: 0.1}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0.01}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.1, 0.1, -0.1], max: [0.1, 0.2, 0.1]}}]}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [9, 9]}}
    areal_density: 0.5
    stretch: 100
    strain_limit: 0.02
    pin: [{corners: true}]
bodies: [{sphere: {center: [0.6, 0, 0], radius: 0.1, dynamic: true, density: 500}}]
)";

TEST(Energy, OfAStretchedSheet) {
  const drench::Setup setup = build(parse_scene(sheet_and_ball, "test.yaml"));
  HostState state = setup.state;
  EXPECT_NEAR(energies_of(setup.model, state).stretch, 0, 1e-20);
  // To 1.05 times its length along x and z: springs Y with Poisson's ratio 1/3 of Van Gelder's membrane, limits 20 Y
  // at 1.02.
  for (Vec3& x : state.node_position) x[0] *= 1.05, x[2] *= 1.05;
  double springs = 0;
  const ClothMesh& mesh = setup.model.mesh;
  for (std::size_t k = 0; k < mesh.edge.size(); ++k)
    springs += 0.5 * mesh.edge_stiffness[k] * std::pow(0.05 * mesh.edge_length[k], 2);
  const double limits = 0.5 * 20 * 100 * 0.16 * 2 * 0.03 * 0.03;
  EXPECT_NEAR(energies_of(setup.model, state).stretch, springs + limits, 1e-9 * (springs + limits));
  EXPECT_NEAR(energies_of(setup.model, state).bend, 0, 1e-12) << "it is flat";
}

TEST(Energy, OfAWovenSheet) {
  const std::string scene = std::string(sheet_and_ball)
                                .replace(std::string(sheet_and_ball).find("    stretch: 100\n    strain_limit: 0.02\n"),
                                         std::string("    stretch: 100\n    strain_limit: 0.02\n").size(),
                                         "    membrane: {warp: 100, weft: 60, shear: 20}\n    warp: [0, 0, 1]\n");
  const drench::Setup setup = build(parse_scene(scene, "test.yaml"));
  HostState state = setup.state;
  EXPECT_NEAR(energies_of(setup.model, state).stretch, 0, 1e-20);
  // To 1.05 and 1.02 times its length along weft and warp, and then with the warp leaning by the angle whose tangent is
  // 0.1.
  for (Vec3& x : state.node_position) x[0] *= 1.05, x[2] *= 1.02;
  const double area = 0.16, stretched = 0.5 * area * (60 * 0.05 * 0.05 + 100 * 0.02 * 0.02);
  const double lines = 20 * 0.5 * area;  // the lines between the yarns stretch alike
  EXPECT_NEAR(energies_of(setup.model, state).stretch, stretched, 1e-9 * stretched);
  for (Vec3& x : state.node_position) x[0] += 0.1 / 1.02 * x[2];
  const double warp = std::hypot(0.1, 1.02) - 1, p = std::hypot(1.15, 1.02), q = std::hypot(0.95, 1.02);
  const double sheared = 0.5 * area * (60 * 0.05 * 0.05 + 100 * warp * warp) + lines * (p - q) * (p - q) / 2;
  EXPECT_NEAR(energies_of(setup.model, state).stretch, sheared, 1e-9 * sheared);
}

TEST(Energy, OfYarnsThatLock) {
  const std::string keys = "    stretch: 100\n    strain_limit: 0.02\n";
  std::string scene = sheet_and_ball;
  scene.replace(scene.find(keys), keys.size(),
                "    membrane: {warp: 100, weft: 60, shear: 20, warp_locking: 0.1, weft_locking: 0.2}\n"
                "    warp: [0, 0, 1]\n");
  const drench::Setup setup = build(parse_scene(scene, "test.yaml"));
  HostState state = setup.state;
  for (Vec3& x : state.node_position) x[0] *= 1.05, x[2] *= 0.98;
  const double area = 0.16, weft = -0.5 * 60 * 0.2 * 0.2 * std::log(1 - 0.25 * 0.25),
               warp = 0.5 * 100 * 0.02 * 0.02;  // which is compressed
  EXPECT_NEAR(energies_of(setup.model, state).stretch, area * (weft + warp), 1e-9 * area * (weft + warp));
}

TEST(Energy, OfABodyThatTurnsAndRises) {
  const drench::Setup setup = build(parse_scene(sheet_and_ball, "test.yaml"));
  HostState state = setup.state;
  const double mass = 500 * 4 * std::numbers::pi / 3 * 1e-3;
  state.body_velocity[0] = {0, 3, 0};
  state.body_angular_velocity[0] = {0, 0, 10};
  const Energies energy = energies_of(setup.model, state);
  EXPECT_NEAR(energy.body_kinetic, 0.5 * mass * 9 + 0.5 * 0.4 * mass * 0.01 * 100, 1e-9);
  EXPECT_NEAR(energy.body_potential, mass * 9.81 * 1, 1e-9);
}

class EnergyOfARun : public Commands {};

TEST_F(EnergyOfARun, ChangesAsTheWatchSaysAndNeverRises) {
  write_text(here() / "both.yaml", sheet_and_ball);
  ASSERT_EQ(drench({"run", "both.yaml", "-o", "o", "--quiet"}).code, 0);
  const Table table = read_table(here() / "o/energy.csv");
  EXPECT_EQ(table.header,
            (std::vector<std::string>{"time", "liquid_kinetic", "liquid_potential", "cloth_kinetic", "cloth_potential",
                                      "stretch", "bend", "body_kinetic", "body_potential", "total"}));
  ASSERT_EQ(table.rows.size(), 11U);
  const Table stats = read_table(here() / "o/stats.csv");
  EXPECT_NEAR(table.number(10, "liquid_kinetic") + table.number(10, "cloth_kinetic"),
              stats.number(stats.rows.size() - 1, "kinetic_energy"), 1e-5);
  for (std::size_t r = 1; r < table.rows.size(); ++r)
    EXPECT_LE(table.number(r, "total"), table.number(r - 1, "total") * (1 + 1e-6)) << "frame " << r;
  // The ball falls freely: v = g t, half a step behind in height.
  const double v = 9.81 * 0.1, mass = 500 * 4 * std::numbers::pi / 3 * 1e-3;
  EXPECT_NEAR(table.number(10, "body_kinetic"), 0.5 * mass * v * v, 1e-4 * mass);
}

TEST(Energy, AgreesWithTheWatch) {
  const drench::Setup setup = build(parse_scene(sheet_and_ball, "test.yaml"));
  HostState state = setup.state;
  const double ours = energies_of(setup.model, state).total(), theirs = mechanical_energy(setup.model, state);
  for (std::size_t n = 0; n < state.node_position.size(); ++n) {
    const double k = static_cast<double>(n);
    Vec3& x = state.node_position[n];
    x = {1.1 * x[0] + 0.01 * std::sin(k), 0.05 * std::cos(2 * k), 1.05 * x[2]};
    state.node_velocity[n] = {std::cos(k), 0, 1};
  }
  for (Vec3& x : state.fluid_position) x[1] -= 0.3;
  state.body_position[0][1] += 0.2;
  state.body_angular_velocity[0] = {1, 2, 3};
  EXPECT_NEAR(energies_of(setup.model, state).total() - ours, mechanical_energy(setup.model, state) - theirs, 1e-9);
}

}  // namespace
}  // namespace drench::test
