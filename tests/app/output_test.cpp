// What the writers put on disk, read back by VTK: fields, units, times, relative paths, turning bodies, offenders.

#include <gtest/gtest.h>
#include <vtkCellData.h>

#include <cmath>
#include <numbers>
#include <set>

#include "frame_reader.hpp"
#include "output/stats_csv.hpp"
#include "output/text_file.hpp"
#include "output/vtu_series.hpp"
#include "output_example.hpp"
#include "run_program.hpp"
#include "setup/body_geometry.hpp"

namespace drench::test {
namespace {

/// A square of two triangles in the plane z = 0 that turns about z through its centre.
Body turning_square(double degrees_per_second) {
  Body body;
  body.kind = BodyScene::Kind::mesh;
  body.center = {0.5, 0.5, 0};
  body.spin_axis = {0, 0, 1};
  body.spin_rate = degrees_per_second * std::numbers::pi / 180;
  body.mesh_points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  body.mesh_triangles = {{0, 1, 2}, {0, 2, 3}};
  return body;
}

void expect_point(vtkUnstructuredGrid* grid, vtkIdType i, const Vec3& expected) {
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(grid->GetPoint(i)[k], expected[k], 1e-6) << "point " << i;
}

TEST(Output, FluidFieldsHaveTheirUnits) {
  const TempFolder folder;
  const Example e;
  FrameWriter(folder.path(), e.model).write(e.state);
  auto grid = read_frame(folder.path() / "frames/fluid_000000.vtu");
  EXPECT_EQ(point_fields(grid),
            (std::vector<std::string>{"age", "density", "id", "mass", "pressure", "radius", "velocity"}));
  ASSERT_EQ(grid->GetNumberOfPoints(), 3);
  ASSERT_EQ(grid->GetNumberOfCells(), 3);
  for (vtkIdType c = 0; c < 3; ++c) EXPECT_EQ(grid->GetCellType(c), VTK_VERTEX);
  expect_point(grid, 2, {0.2, 0.5, 0});
  for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(field(grid, "velocity", 0, k), 1 + k);
  EXPECT_FLOAT_EQ(field(grid, "density", 1), 808);
  EXPECT_FLOAT_EQ(field(grid, "density", 2), 400);
  EXPECT_FLOAT_EQ(field(grid, "pressure", 1), 2000);
  EXPECT_DOUBLE_EQ(field(grid, "mass", 0), 0.8);
  EXPECT_DOUBLE_EQ(field(grid, "mass", 1), 0.1);
  EXPECT_FLOAT_EQ(field(grid, "radius", 0), 0.05);
  EXPECT_FLOAT_EQ(field(grid, "radius", 1), 0.025);
  EXPECT_EQ(field(grid, "id", 1), 123456789012345.0);
  EXPECT_FLOAT_EQ(field(grid, "age", 2), 0.25);
}

TEST(Output, ClothFieldsHaveTheirUnits) {
  const TempFolder folder;
  const Example e;
  FrameWriter(folder.path(), e.model).write(e.state);
  auto grid = read_frame(folder.path() / "frames/cloth_000000.vtu");
  EXPECT_EQ(point_fields(grid),
            (std::vector<std::string>{"flow_direction", "liquid_mass", "pin_force", "saturation", "velocity"}));
  ASSERT_EQ(grid->GetNumberOfPoints(), 3);
  ASSERT_EQ(grid->GetNumberOfCells(), 1);
  EXPECT_EQ(grid->GetCellType(0), VTK_TRIANGLE);
  EXPECT_DOUBLE_EQ(field(grid, "liquid_mass", 0), 0.2);
  EXPECT_FLOAT_EQ(field(grid, "saturation", 0), 0.5);
  EXPECT_FLOAT_EQ(field(grid, "saturation", 1), 0.5);
  EXPECT_EQ(field(grid, "saturation", 2), 0) << "a node without capacity is dry";
  EXPECT_FLOAT_EQ(field(grid, "flow_direction", 0, 0), 0.5 / 0.75);
  EXPECT_FLOAT_EQ(field(grid, "flow_direction", 0, 1), 0.25 / 0.75);
  EXPECT_FLOAT_EQ(field(grid, "flow_direction", 2, 1), 1);
  EXPECT_FLOAT_EQ(field(grid, "velocity", 1, 1), -2);
  EXPECT_FLOAT_EQ(field(grid, "pin_force", 0, 1), 5);
  EXPECT_EQ(field(grid, "pin_force", 1, 1), 0);
}

TEST(Output, FieldsThatASceneDoesNotComputeAreZero) {
  Example e;
  e.state.fluid_kappa_density.clear();
  e.state.node_liquid.clear();
  e.state.node_pin_force.clear();
  e.state.sample_flow_direction.clear();
  e.model.samples.node_capacity.clear();
  const TempFolder folder;
  FrameWriter(folder.path(), e.model).write(e.state);
  auto fluid = read_frame(folder.path() / "frames/fluid_000000.vtu");
  auto cloth = read_frame(folder.path() / "frames/cloth_000000.vtu");
  EXPECT_EQ(field(fluid, "pressure", 1), 0);
  for (const char* name : {"saturation", "liquid_mass"}) EXPECT_EQ(field(cloth, name, 0), 0);
  EXPECT_EQ(field(cloth, "flow_direction", 0, 0), 0);
  EXPECT_EQ(field(cloth, "pin_force", 0, 1), 0);
}

TEST(Output, CollectionsHaveRealTimesAndRelativePathsAfterEveryFrame) {
  const TempFolder folder;
  Example e;
  FrameWriter writer(folder.path(), e.model);
  const std::vector<double> times{0, 0.0213, 0.04};
  for (std::size_t f = 0; f < times.size(); ++f) {
    e.state.time = times[f];
    writer.write(e.state);
    for (const char* name : {"fluid", "cloth"}) {
      const auto entries = read_collection(folder.path() / (std::string(name) + ".pvd"));
      ASSERT_EQ(entries.size(), f + 1);
      for (std::size_t i = 0; i <= f; ++i) {
        EXPECT_DOUBLE_EQ(entries[i].time, times[i]);
        EXPECT_TRUE(fs::path(entries[i].file).is_relative());
        EXPECT_EQ(read_frame(folder.path() / entries[i].file)->GetNumberOfPoints(), 3);
      }
    }
  }
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"cloth.pvd", "energy.csv", "fluid.pvd", "frames"}))
      << "no bodies, and no temporary file is left";
  EXPECT_EQ(names_in(folder.path() / "frames").size(), 6U);
}

TEST(Output, OnlyWhatTheSceneHasIsWritten) {
  const TempFolder folder;
  Example e;
  e.model.cloths.clear();
  FrameWriter writer(folder.path(), e.model);
  writer.write(e.state);
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"energy.csv", "fluid.pvd", "frames"}));
  EXPECT_EQ(writer.collections(), std::vector<std::string>{"fluid.pvd"});
}

TEST(Output, AnEmptyFluidIsReadable) {
  const TempFolder folder;
  Example e;
  e.state = HostState{};
  e.model.cloths.clear();
  FrameWriter(folder.path(), e.model).write(e.state);
  auto grid = read_frame(folder.path() / "frames/fluid_000000.vtu");
  EXPECT_EQ(grid->GetNumberOfPoints(), 0);
}

TEST(Output, StillBodiesAreWrittenOnceAndMovingOnesTurn) {
  const TempFolder folder;
  Example e;
  Body floor, ball;
  floor.kind = BodyScene::Kind::plane;
  ball.kind = BodyScene::Kind::sphere;
  ball.center = {0, 0.5, 0};
  ball.radius = 0.25;
  e.model.bodies = {floor, ball, turning_square(90)};
  FrameWriter writer(folder.path(), e.model);
  start_bodies(e.model, e.state);
  for (const double time : {0.0, 1.0, 1.5}) {
    e.state.time = time;
    const double half = 0.5 * e.model.bodies[2].spin_rate.plain() * time;
    e.state.body_orientation[2] = {std::cos(half), 0, 0, std::sin(half)};
    writer.write(e.state);
  }
  const auto entries = read_collection(folder.path() / "bodies.pvd");
  ASSERT_EQ(entries.size(), 6U);
  std::set<std::string> still;
  for (const auto& entry : entries)
    if (entry.part == 0) still.insert(entry.file);
  EXPECT_EQ(still.size(), 1U);
  auto turned = read_frame(folder.path() / entries[3].file);  // a quarter turn about (0.5, 0.5)
  expect_point(turned, 0, {1, 0, 0});
  expect_point(turned, 1, {1, 1, 0});
  expect_point(turned, 2, {0, 1, 0});
  auto further = read_frame(folder.path() / entries[5].file);  // 135 degrees
  expect_point(further, 0, {0.5 + std::sqrt(0.5), 0.5, 0});

  auto solid = read_frame(folder.path() / entries[0].file);
  double farthest = 0;
  for (vtkIdType i = 4; i < solid->GetNumberOfPoints(); ++i)
    farthest = std::max(
        farthest,
        std::abs(std::hypot(solid->GetPoint(i)[0], solid->GetPoint(i)[1] - 0.5, solid->GetPoint(i)[2]) - 0.25));
  EXPECT_LT(farthest, 1e-6) << "the sphere's points lie on it";
}

TEST(Output, BodiesAreShownWhereTheyAre) {
  Example e;
  Body box, ball, plane;
  box.box = {{-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}};
  box.dynamic = true;
  ball.kind = BodyScene::Kind::sphere;
  ball.radius = 0.1;
  ball.velocity = {1, 0, 0};
  plane.kind = BodyScene::Kind::plane;
  plane.velocity = {0, 1, 0};
  e.model.bodies = {box, ball, plane};
  start_bodies(e.model, e.state);
  e.state.body_position = {{0.5, 0.5, 0.5}, {0.25, 0, 0}, {0, 0.5, 0}};
  e.state.body_orientation[0] = {std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // a quarter turn: x and y change places
  for (const std::size_t k : {0, 1, 2}) {
    Model one = e.model;
    one.bodies = {e.model.bodies[k]};
    HostState state = e.state;
    state.body_position = {e.state.body_position[k]};
    state.body_orientation = {e.state.body_orientation[k]};
    double b[6];
    bodies_grid(one, &state)->GetBounds(b);
    const double expected[3][6] = {
        {0.3, 0.7, 0.4, 0.6, 0.2, 0.8}, {0.15, 0.35, -0.1, 0.1, -0.1, 0.1}, {-1, 1, 0.5, 0.5, -1, 1}};
    for (int a = 0; a < 6; ++a) EXPECT_NEAR(b[a], expected[k][a], 2e-3) << "body " << k << " bound " << a;
    EXPECT_EQ(bodies_grid(one, nullptr)->GetNumberOfCells(), 0);
  }
}

TEST(Output, StillBodiesAloneTakeOneEntry) {
  const TempFolder folder;
  Example e;
  Body box;
  box.box = {{-0.5, 0, -0.5}, {0.5, 1, 0.5}};
  box.inside = true;
  e.model.bodies = {box};
  FrameWriter writer(folder.path(), e.model);
  writer.write(e.state);
  e.state.time = 1;
  writer.write(e.state);
  const auto entries = read_collection(folder.path() / "bodies.pvd");
  ASSERT_EQ(entries.size(), 1U);
  auto grid = read_frame(folder.path() / entries[0].file);
  EXPECT_EQ(grid->GetNumberOfPoints(), 8);
  EXPECT_EQ(grid->GetNumberOfCells(), 6);
  EXPECT_EQ(grid->GetCellData()->GetArray("container")->GetComponent(0, 0), 1);
  double bounds[6];
  grid->GetBounds(bounds);
  EXPECT_DOUBLE_EQ(bounds[3], 1);
}

/// Area of a planar polygon, by the cross products of its fan.
double polygon_area(vtkUnstructuredGrid* grid) {
  Vec3 sum{0, 0, 0};
  const vtkIdType n = grid->GetNumberOfPoints();
  const auto edge = [&](vtkIdType i, int k) { return grid->GetPoint(i)[k] - grid->GetPoint(0)[k]; };
  for (vtkIdType i = 1; i + 1 < n; ++i)
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      sum[static_cast<std::size_t>(k)] += 0.5 * (edge(i, a) * edge(i + 1, b) - edge(i, b) * edge(i + 1, a));
    }
  return std::hypot(sum[0], sum[1], sum[2]);
}

TEST(Output, PlanesEndAtTheDomain) {
  Example e;
  Body plane;
  plane.kind = BodyScene::Kind::plane;
  const double third = 1 / std::sqrt(3.0), half = std::sqrt(0.5);
  struct Case {
    Vec3 point, normal;
    int corners;
    double area;
  };
  for (const Case& c : {Case{{0, 0.2, 0}, {0, 1, 0}, 4, 4.0},                           // a square across the domain
                        Case{{0, -1, 0}, {0, 1, 0}, 4, 4.0},                            // on its floor
                        Case{{0, 0, 0}, {third, third, third}, 6, 3 * std::sqrt(3.0)},  // a regular hexagon
                        Case{{0, 0, 0}, {half, half, 0}, 4, 4 * std::sqrt(2.0)},        // through four corners
                        Case{{1, 1, 0.5}, {third, third, third}, 3, 0.125 * std::sqrt(3.0)},
                        Case{{0, 7, 0}, {0, 1, 0}, 0, 0.0}}) {  // outside
    plane.point = c.point;
    plane.normal = c.normal;
    e.model.bodies = {plane};
    const Grid grid = bodies_grid(e.model, nullptr);
    ASSERT_EQ(grid->GetNumberOfPoints(), c.corners);
    EXPECT_EQ(grid->GetNumberOfCells(), c.corners > 0 ? 1 : 0);
    EXPECT_NEAR(c.corners > 0 ? polygon_area(grid) : 0.0, c.area, 1e-5);
  }
}

TEST(Output, OffendersAreFoundNamedAndWritten) {
  Example e;
  EXPECT_TRUE(find_offenders(e.state).empty());
  e.state.fluid_position[1][2] = std::nan("");
  e.state.fluid_velocity[2][0] = INFINITY;
  e.state.node_velocity[2][1] = std::nan("");
  e.state.body_position = {{0, 0, 0}, {0, 1, 0}};
  e.state.body_velocity = {{0, 0, 0}, {0, 0, 0}};
  e.state.body_angular_velocity = {{0, 0, 0}, {0, std::nan(""), 0}};
  e.state.body_orientation.assign(2, Quaternion{1, 0, 0, 0});
  const Offenders bad = find_offenders(e.state);
  EXPECT_EQ(bad.bodies, (std::vector<Index>{1}));
  EXPECT_EQ(bad.particles, (std::vector<Index>{1, 2}));
  EXPECT_EQ(bad.nodes, (std::vector<Index>{2}));
  EXPECT_EQ(describe(bad, e.state), "particles 123456789012345 9, nodes 2, bodies 1");
  EXPECT_EQ(describe(bad, e.state, 1), "particles 123456789012345 and 1 more, nodes 2, bodies 1");
  const TempFolder folder;
  write_vtu(folder.path() / "failure.vtu", offender_grid(e.model, e.state, bad));
  auto grid = read_frame(folder.path() / "failure.vtu");
  ASSERT_EQ(grid->GetNumberOfPoints(), 4);
  EXPECT_EQ(field(grid, "kind", 3), 2);
  expect_point(grid, 0, {0.1, 0.5, 0});
  EXPECT_TRUE(std::isnan(field(grid, "position", 0, 2)));
  EXPECT_EQ(field(grid, "id", 1), 9);
  EXPECT_EQ(field(grid, "kind", 2), 1);
}

TEST(Output, MassesThatNoParticleCanHaveAreOffenders) {
  Example e;
  e.state.fluid_mass[0] = -1;
  e.state.node_liquid[1] = -1;
  const Offenders bad = find_offenders(e.state);
  EXPECT_EQ(bad.particles, std::vector<Index>{0});
  EXPECT_EQ(bad.nodes, std::vector<Index>{1});
}

TEST(Output, WritingWhereNothingCanBeWrittenIsAnError) {
  const TempFolder folder;
  const Example e;
  EXPECT_THROW(write_vtu(folder.path() / "missing/a.vtu", fluid_grid(e.model, e.state)), std::runtime_error);
  EXPECT_THROW(write_atomically(folder.path() / "missing/a.txt", "a"), std::runtime_error);
  EXPECT_THROW(StatsCsv(folder.path() / "missing/stats.csv", {}, 1, 0), std::runtime_error);
}

}  // namespace
}  // namespace drench::test
