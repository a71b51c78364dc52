// Meshes as bodies: crossed faces, holes, seams, shells that touch, branches, slivers, and how deep a point is in them.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSelectEnclosedPoints.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "mesh_folder.hpp"
#include "scene/load.hpp"
#include "setup/body_geometry.hpp"
#include "setup/build.hpp"
#include "setup/distance_field.hpp"
#include "setup/mesh_io.hpp"
#include "setup/solid_mesh.hpp"
#include "setup/surface_distance.hpp"
#include "state/mass_budget.hpp"

namespace drench::testing {
namespace {

using Eigen::Vector3d;
using test::box_mesh;
using test::obj_of;
using test::TestMesh;

SurfaceMesh surface_of(const TestMesh& mesh) {
  SurfaceMesh surface;
  for (const Vector3d& x : mesh.points) surface.points.push_back(to_vec3(x));
  surface.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  return surface;
}

Body body_of(const SolidMesh& solid, const SurfaceMesh& mesh) {
  Body body;
  body.kind = BodyScene::Kind::mesh;
  for (const Index i : solid.source) body.mesh_points.push_back(mesh.points[static_cast<std::size_t>(i)]);
  body.mesh_triangles = solid.triangles;
  return body;
}

Body solid_of(const TestMesh& mesh) {
  const SurfaceMesh surface = surface_of(mesh);
  return body_of(close_mesh(surface), surface);
}

TestMesh both(TestMesh a, const TestMesh& b) {
  const int first = static_cast<int>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

/// A box that `place` turns is a mesh of the same volume, whose distances are a box's.
TEST(BodyBoxes, ATurnedOneIsABox) {
  const Scene scene = parse_scene(R"(drench: 1
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [0.8, 0.8, 0.8], max: [0.9, 0.9, 0.9]}}]}
bodies:
  - box: {min: [-0.3, -0.05, -0.2], max: [0.3, 0.05, 0.2], dynamic: true, density: 500}
    place: {position: [0.1, 0.2, -0.1], rotate: {axis: [1, 2, 3], degrees: 40}}
  - box: {min: [-0.3, -0.05, -0.2], max: [0.3, 0.05, 0.2]}
    place: {position: [0, -0.5, 0]}
)",
                                  "turned.yaml");
  const drench::Setup setup = build(scene);
  const Body& turned = setup.model.bodies[0];
  EXPECT_NEAR(turned.mass, 500 * 0.6 * 0.1 * 0.4, 1e-9);
  EXPECT_EQ(setup.model.bodies[1].kind, BodyScene::Kind::box);
  EXPECT_NEAR(setup.model.bodies[1].center[1], -0.5, 1e-15);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(40 * std::numbers::pi / 180, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(-1, 1);
  int near = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector3d own(0.35 * part(random), 0.1 * part(random), 0.25 * part(random));
    const Vector3d over = own.cwiseAbs() - Vector3d(0.3, 0.05, 0.2);
    const double expected = over.cwiseMax(0).norm() + std::min(0.0, over.maxCoeff());
    if (std::abs(expected) > 0.03) continue;
    ++near;
    Vec3 normal;
    EXPECT_NEAR(signed_distance(turned, to_vec3(turn * own + Vector3d(0.1, 0.2, -0.1)), normal), expected, 0.004)
        << "m";
  }
  EXPECT_GT(near, 1000);
  EXPECT_EQ(parse_scene(to_yaml(scene), "turned.yaml").bodies[0], scene.bodies[0]);
}

/// A sphere that is scaled alike stays one, otherwise it is a mesh of the ellipsoid's volume; planes turn and move.
TEST(PlacedBodies, AreScaledTurnedAndMoved) {
  const Scene scene = parse_scene(R"(drench: 1
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
fluid: {spacing: 0.02, sources: [{block: {min: [0.8, 0.8, 0.8], max: [0.9, 0.9, 0.9]}}]}
bodies:
  - sphere: {center: [0.1, 0, 0], radius: 0.1, dynamic: true, density: 400}
    place: {scale: [2, 0.5, 1], rotate: {axis: [0, 0, 1], degrees: 90}, position: [0, 0.3, 0]}
  - sphere: {center: [-0.5, 0, 0], radius: 0.1}
    place: {scale: [1.5, 1.5, 1.5], position: [0, 0.2, 0]}
  - box: {min: [-0.2, -0.2, -0.2], max: [0.2, 0.2, 0.2]}
    place: {scale: [0.5, 1, 2], position: [0, -0.6, 0]}
  - plane: {point: [0, -0.9, 0], normal: [0, 1, 0]}
    place: {rotate: {axis: [0, 0, 1], degrees: 30}, position: [0, -0.05, 0]}
)",
                                  "placed.yaml");
  const drench::Setup setup = build(scene);
  const Body &egg = setup.model.bodies[0], &ball = setup.model.bodies[1], &box = setup.model.bodies[2],
             &slope = setup.model.bodies[3];
  EXPECT_NEAR(egg.mass / (400 * 4.0 / 3 * std::numbers::pi * 0.2 * 0.05 * 0.1), 0.997, 0.002);
  for (const Vec3& x : egg.mesh_points)
    EXPECT_NEAR(std::pow((x[0] - 0.1) / 0.05, 2) + std::pow((x[1] - 0.3) / 0.2, 2) + std::pow(x[2] / 0.1, 2), 1, 1e-12);
  EXPECT_EQ(ball.kind, BodyScene::Kind::sphere);
  EXPECT_NEAR(ball.radius, 0.15, 1e-15);
  EXPECT_NEAR(ball.center[1], 0.2, 1e-15);
  const Vec3 low{-0.1, -0.8, -0.4}, high{0.1, -0.4, 0.4};
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(box.box.min[a], low[a], 1e-15);
    EXPECT_NEAR(box.box.max[a], high[a], 1e-15);
  }
  EXPECT_NEAR(slope.normal[0], -0.5, 1e-15);
  EXPECT_NEAR(slope.point[1], -0.95, 1e-15);
  const Scene again = parse_scene(to_yaml(scene), "placed.yaml");
  for (std::size_t b = 0; b < 4; ++b) EXPECT_EQ(again.bodies[b], scene.bodies[b]) << b;
}

class BodyMeshes : public MeshFolder {
 protected:
  /// A block of liquid around the body, and a cloth above it if asked for.
  drench::Setup set_up(const std::string& file, bool cloth, const std::string& more = "") const {
    return built(
        fmt::format("drench: 1\nfluid: {{spacing: 0.1, sources: [{{block: {{min: [-1.5, -1.5, -1.5], max: "
                    "[1.5, 1.5, 1.5]}}}}]}}\ndomain: {{min: [-3, -3, -3], max: [3, 3, 3]}}\n{}bodies: [{{mesh: "
                    "{{file: {}{}}}}}]\n",
                    cloth ? "cloth: [{mesh: {grid: {size: [1, 1], nodes: [5, 5]}}, place: {position: [0, 2, "
                            "0]}}]\n"
                          : "",
                    file, more));
  }
  std::string refusal(const std::string& file, bool cloth, const std::string& more = "") const {
    return refusal_of([&] { set_up(file, cloth, more); });
  }
};

bool warns_of(const drench::Setup& setup, const std::string& part) { return any_has(setup.warnings, part); }

TEST_F(BodyMeshes, ABoxWithACrossedFaceIsClosedInEveryFormat) {
  const std::string faces[] = {"1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8", "5 6 7 8", "4 3 2 1"};
  const std::string points = "0 0 0\n1 0 0\n1 0 1\n0 0 1\n0.55 1 0\n0.45 1 0\n1 1 1\n0 1 1\n";
  std::string obj, ply =
                       "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 6\nproperty list uchar int vertex_indices\nend_header\n" +
                       points;
  for (std::size_t at = 0; at < points.size(); at = points.find('\n', at) + 1)
    obj += "v " + points.substr(at, points.find('\n', at) + 1 - at);
  for (const std::string& face : faces) {
    obj += "f " + face + "\n";
    ply += "4";
    for (std::size_t k = 0; k < face.size(); k += 2) ply += fmt::format(" {}", face[k] - '1');
    ply += "\n";
  }
  const SurfaceMesh mesh = read_mesh(write("box.obj", obj), "");
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(mesh.left_out, "");
  EXPECT_EQ(read_mesh(write("box.ply", ply), "").triangles, mesh.triangles);
  std::string later = obj;  // in it the face does not cross itself
  later.replace(later.find("0.55 1 0"), 8, "0.00 1 0").replace(later.find("0.45 1 0"), 8, "1.00 1 0");
  const MeshSequenceReader sequence({.files = {write("0.obj", obj), write("1.obj", later)}}, "", "");
  EXPECT_EQ(sequence.read(1).triangles, mesh.triangles);
}

TEST_F(BodyMeshes, WhatHasNoAreaIsLeftOutAndReportedOnce) {
  const std::string file = write("concave.obj",
                                 "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0.5 0 0.2\nv 0 0 1\nv 2 0 0\nv 3 0 0\nv 4 0 0\n"
                                 "f 1 2 3 4 5\nf 6 7 8\nf 1 1 2\n");
  Scene scene;
  ClothScene cloth;
  cloth.name = "sheet";
  cloth.file = file;
  scene.cloths.push_back(cloth);
  const drench::Setup setup = build(scene);
  EXPECT_EQ(setup.model.mesh.triangles(), 3);
  EXPECT_EQ(setup.model.mesh.nodes(), 5);
  EXPECT_TRUE(warns_of(
      setup,
      "2 of 5 triangles have no area or name a point twice and are omitted; the first belongs to face 1 (line 10)"));
}

TEST_F(BodyMeshes, ShellsThatTouchStayTwoPiecesWithAndWithoutTexture) {
  const TestMesh touching = both(box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({1, 0, 0}, {2, 1, 1}));
  std::string plain = obj_of(touching), textured = plain;
  textured.insert(textured.find("f "), "vt 0 0\nvt 1 0\n");
  std::string stl = "solid\n";
  for (const auto& t : touching.triangles) {
    stl += "facet normal 0 0 1\nouter loop\n";
    for (const int k : t) {
      const Vector3d& x = touching.points[static_cast<std::size_t>(k)];
      stl += fmt::format("vertex {} {} {}\n", x[0], x[1], x[2]);
    }
    stl += "endloop\nendfacet\n";
  }
  std::string words;
  for (std::size_t at = textured.find("f "), k = 0; at < textured.size(); ++at) {
    const bool ends = textured[at] == ' ' || textured[at] == '\n';
    if (ends && at > 0 && textured[at - 1] != 'f') words += k++ % 2 ? "/1" : "/2";
    words += textured[at];
  }
  textured = textured.substr(0, textured.find("f ")) + words;
  for (const std::string& file :
       {write("plain.obj", plain), write("textured.obj", textured), write("facets.stl", stl + "endsolid\n")}) {
    SCOPED_TRACE(file);
    const SurfaceMesh mesh = read_mesh(file, "");
    EXPECT_EQ(mesh.points.size(), 16u);
    EXPECT_TRUE(is_closed(mesh));
    for (const bool cloth : {false, true}) {
      const drench::Setup setup = set_up(file, cloth, ", position: [-1, -0.5, -0.5]");
      const Body& body = setup.model.bodies[0];
      EXPECT_EQ(body.mesh_points.size(), 16u);
      Vec3 normal;  // how deep: the faces that touch are no surface
      EXPECT_NEAR(signed_distance(body, {0, 0, 0}, normal), -0.5, 0.1);
      EXPECT_NEAR(signed_distance(body, {1.02, 0, 0}, normal), 0.02, 1e-3);
      for (const Vec3& x : setup.state.fluid_position)
        EXPECT_TRUE(std::abs(x[0]) > 1 || std::abs(x[1]) > 0.5 || std::abs(x[2]) > 0.5);
    }
  }
}

/// What is left of a unit ball below a height.
TestMesh ball_below(double height) {
  TestMesh mesh = test::ball_mesh(3);
  std::erase_if(mesh.triangles, [&](const std::array<int, 3>& t) {
    return std::any_of(t.begin(), t.end(), [&](int k) { return mesh.points[static_cast<std::size_t>(k)][1] > height; });
  });
  return mesh;
}

TEST_F(BodyMeshes, ALargeOneHasALatticeThatFitsIntoMemory) {
  const Vec3 low{-1, -1, -1}, high{1, 1, 1};
  const DistanceField fine = lay_field(low, high, 0.02, 0.01), coarse = lay_field(low, high, 0.004, 0.01);
  EXPECT_EQ(fine.spacing, 0.01);
  EXPECT_EQ(coarse_field(fine, 0.02), "");
  double points = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    points *= double(coarse.points[a]);
    EXPECT_LE(coarse.origin[a], -1.01 - coarse.spacing);
    EXPECT_GE(coarse.origin[a] + double(coarse.points[a] - 1) * coarse.spacing, 1.01 + coarse.spacing);
  }
  EXPECT_LE(points, most_field_points);
  EXPECT_GT(points, 0.8 * most_field_points);
  const std::string line = coarse_field(coarse, 0.004);
  EXPECT_EQ(line.find("its lattice of distances, 2 m long, is limited to steps of 0.0052 m instead of 0.002 m, "), 0U)
      << line;
  EXPECT_LT(line.size(), 280U) << line;
}

/// Parts of a mesh may lie on, in and across each other: liquid and dynamic bodies have the mass of what is inside.
TEST_F(BodyMeshes, MassesAreThoseOfWhatIsInside) {
  const TestMesh cube = box_mesh({0, 0, 0}, {1, 1, 1}), across = both(cube, box_mesh({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}));
  TestMesh inner = box_mesh({0.21, 0.2, 0.23}, {0.8, 0.8, 0.8});
  for (auto& t : inner.triangles) std::swap(t[0], t[1]);
  const auto turned = [](TestMesh mesh) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    for (Vector3d& x : mesh.points) x = turn * x;
    return mesh;
  };
  struct Case {
    TestMesh mesh;
    double volume, exact;
    Vector3d inertia;  // principal ones over the density
  };
  // Of a cube of side a, displaced by d along each axis: a^3 (a^2 + 12 d^2) / 6 about each axis, -a^3 d^2 between two.
  const auto about_axes = [](double a, double d) {
    const double cubed = a * a * a;
    return Eigen::Matrix3d(Eigen::Matrix3d::Identity() * cubed * (a * a / 6 + 3 * d * d) -
                           Eigen::Matrix3d::Constant(cubed * d * d));
  };
  const Eigen::Matrix3d of_both = about_axes(1, 0.25) + about_axes(1, -0.25) - about_axes(0.5, 0);
  const Vector3d one(1.0 / 6, 1.0 / 6, 1.0 / 6);
  const double low = of_both.row(0).sum(), high = of_both(0, 0) - of_both(0, 1);
  const Vector3d two(low, high, high);
  for (const Case& c : {Case{cube, 1, 1e-14, one}, Case{both(cube, cube), 1, 1e-11, one},
                        Case{both(cube, inner), 1, 1e-11, one}, Case{across, 1.875, 1e-11, two},
                        Case{turned(both(cube, inner)), 1, 1e-4, one}, Case{turned(across), 1.875, 2e-4, two}}) {
    const std::string file = write("parts.obj", obj_of(c.mesh));
    const drench::Setup setup =
        built(fmt::format("drench: 1\ndomain: {{min: [-3, -3, -3], max: [9, 9, 9]}}\n"
                          "fluid: {{spacing: 0.1, sources: [{{mesh: {{file: {0}, position: [5, 5, 5]}}}}]}}\n"
                          "bodies: [{{mesh: {{file: {0}, dynamic: true, density: 500}}}}]\n",
                          file));
    const double mass = static_cast<double>(sum_of(setup.state.fluid_mass)) * setup.model.quantum;
    EXPECT_NEAR(mass, 1000 * c.volume, 1000 * c.exact + 1e-6);
    const Body& body = setup.model.bodies[0];
    EXPECT_NEAR(body.mass, 500 * c.volume, 500 * c.exact);
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(body.inertia[a], 500 * c.inertia[static_cast<int>(a)], 500 * c.exact);
  }
}

/// Two cubes of squares with the points of a face in common, and that face in both of them or as one wall.
TEST_F(BodyMeshes, AWallBetweenTwoRoomsIsNoHole) {
  const std::string points =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 2 0 0\nv 2 1 0\nv 2 1 1\nv 2 0 1\n";
  const std::string left = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\n",
                    right = "f 2 3 10 9\nf 6 12 11 7\nf 2 9 12 6\nf 10 3 7 11\nf 9 10 11 12\n", wall = "f 2 3 7 6\n",
                    back = "f 6 7 3 2\n";
  for (const std::string& walls : {wall, wall + back, back + wall}) {
    const drench::Setup setup = set_up(write("rooms.obj", points + left + walls + right), true);
    EXPECT_FALSE(warns_of(setup, "hole")) << ::testing::PrintToString(setup.warnings);
    EXPECT_TRUE(warns_of(setup, "more than two triangles share"));
    const drench::Setup liquid = built(
        "drench: 1\nfluid: {spacing: 0.1, sources: [{mesh: {file: rooms.obj}}]}\ndomain: {min: [-3, -3, -3], max: "
        "[3, 3, 3]}\n");
    EXPECT_TRUE(warns_of(liquid, "the volume that its outer surface encloses is filled"));
    Vec3 normal;
    EXPECT_LT(signed_distance(setup.model.bodies[0], {0.5, 0.5, 0.5}, normal), -0.35);
    EXPECT_LT(signed_distance(setup.model.bodies[0], {1.5, 0.5, 0.5}, normal), -0.35);
  }
}

/// The six sides of a cube as patches of so many squares, each smaller by `gap` along its border.
std::string patches(const std::array<int, 6>& cells, double gap, bool shared) {
  std::string points, faces;
  std::map<std::array<double, 3>, int> number;
  int count = 0;
  const auto add = [&](const Vector3d& x) {
    const auto [found, fresh] = number.try_emplace({x[0], x[1], x[2]}, count + 1);
    if (shared && !fresh) return found->second;
    points += fmt::format("v {:.9g} {:.9g} {:.9g}\n", x[0], x[1], x[2]);
    return found->second = ++count;
  };
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2, n = cells[static_cast<std::size_t>(side)];
    std::vector<int> at;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Vector3d x;
        x[axis] = side % 2;
        x[(axis + 1) % 3] = gap + (1 - 2 * gap) * i / n;
        x[(axis + 2) % 3] = gap + (1 - 2 * gap) * j / n;
        at.push_back(add(x));
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto corner = [&](int k, int l) { return at[static_cast<std::size_t>((j + l) * (n + 1) + i + k)]; };
        faces += fmt::format("f {} {} {} {}\n", corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
      }
  }
  return points + faces;
}

TEST_F(BodyMeshes, PatchesThatMeetWithoutCommonPointsAreOneSolid) {
  struct Case {
    std::array<int, 6> cells;
    double gap;
    bool shared;
  };
  for (const Case& c : {Case{{1, 2, 3, 4, 5, 6}, 0, true}, Case{{4, 6, 5, 8, 7, 4}, 0, false},
                        Case{{4, 4, 4, 4, 4, 4}, 0.001, false}, Case{{4, 6, 5, 8, 7, 4}, 0.001, false}}) {
    const drench::Setup setup = set_up(write("patches.obj", patches(c.cells, c.gap, c.shared)), true);
    EXPECT_TRUE(warns_of(setup, "it is made of patches without common points along their edges, which are joined"));
    EXPECT_EQ(warns_of(setup, "joined across gaps of up to 0.0014 m"), c.gap > 0);
    EXPECT_FALSE(warns_of(setup, "hole")) << ::testing::PrintToString(setup.warnings);
    const Body& body = setup.model.bodies[0];
    EXPECT_TRUE(bounds_solid(body.mesh_triangles));
    const auto distance = exact_distance(body);
    EXPECT_NEAR(distance({0.5, 0.5, 0.5}), -0.5, 0.002);
    EXPECT_NEAR(distance({0.5, 0.5, 1.2}), 0.2, 0.002);
    EXPECT_NEAR(distance({0.97, 0.98, 0.5}), -0.02, 0.002);
  }
  // A sheet stays one, and so do plates that are too far apart.
  EXPECT_TRUE(
      warns_of(set_up(write("apart.obj", patches({4, 4, 4, 4, 4, 4}, 0.02, false)), false), "it encloses no volume"));
}

/// The points of a pole differ by rounding, also in a sequence.
TEST_F(BodyMeshes, PointsAtOnePlaceToRoundingAreOne) {
  constexpr int around = 12, rows = 8;
  const auto ball = [&](double more) {
    std::string text;
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i < around; ++i) {
        const double down = std::numbers::pi * j / rows, angle = 2 * std::numbers::pi * i / around;
        text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", std::sin(down) * std::cos(angle),
                            (1 + more) * (1 + std::cos(down)), std::sin(down) * std::sin(angle));
      }
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < around; ++i) {
        const int a = j * around + i + 1, b = j * around + (i + 1) % around + 1;
        if (j > 0) text += fmt::format("f {} {} {}\n", a, b, a + around);
        if (j + 1 < rows) text += fmt::format("f {} {} {}\n", b, b + around, a + around);
      }
    return text;
  };
  write("ball_0.obj", ball(0));
  write("ball_1.obj", ball(0.1));
  for (const std::string mesh : {"file: ball_0.obj", "sequence: ball_*.obj, fps: 24"}) {
    const drench::Setup setup = built(
        "drench: 1\nfluid: {spacing: 0.1, sources: [{block: {min: [2, 2, 2], max: [2.2, 2.2, 2.2]}}]}\n"
        "bodies: [{mesh: {" +
        mesh + "}}]\n");
    EXPECT_FALSE(warns_of(setup, "hole")) << mesh << ::testing::PrintToString(setup.warnings);
    EXPECT_EQ(setup.model.bodies[0].mesh_points.size(), around * (rows - 1) + 2U) << mesh;
  }
}

TEST_F(BodyMeshes, AnOpenOneIsSolidAndItsHoleReported) {
  Body closed = solid_of(test::ball_mesh(3)), open = solid_of(ball_below(0.85));
  for (Body* body : {&closed, &open}) {
    body->field = lay_field({-1, -1, -1}, {1, 1, 1}, 0.1, 0.1);
    fill_field(*body, body->field);
  }
  double worst = 0;
  const auto [nx, ny, nz] = closed.field.points;
  for (Index k = 0; k < nz; ++k)
    for (Index j = 0; j < ny; ++j)
      for (Index i = 0; i < nx; ++i)
        if (closed.field.origin[1] + j * closed.field.spacing < 0.2) {
          const auto at = static_cast<std::size_t>((k * ny + j) * nx + i);
          const double mine = open.field.value[at], expected = closed.field.value[at];
          if (expected > -0.5) worst = std::max(worst, std::abs(mine - expected));
          EXPECT_EQ(mine < 0, expected < 0);
        }
  EXPECT_LT(worst, 1e-12) << "far from the hole";
  const std::string file = write("open.obj", obj_of(ball_below(0.85)));
  for (const bool cloth : {false, true}) {
    const drench::Setup setup = set_up(file, cloth);
    EXPECT_TRUE(warns_of(setup, "bodies.0 (" + file + "): the mesh has 1 hole, 1."))
        << ::testing::PrintToString(setup.warnings);
    for (const Vec3& x : setup.state.fluid_position) EXPECT_GT(to_eigen(x).norm(), 0.6);
    EXPECT_TRUE(is_closed({setup.model.bodies[0].mesh_points, setup.model.bodies[0].mesh_triangles}));
  }
  // As a vessel it is free on both sides, and no cloth touches it.
  const drench::Setup vessel = set_up(file, false, ", inside: true");
  EXPECT_TRUE(vessel.model.bodies[0].field.empty());
  EXPECT_EQ(vessel.state.fluid_count(), 30 * 30 * 30);
  EXPECT_NE(refusal(file, true, ", inside: true").find("moving cloth cannot touch a mesh with inside: true"),
            std::string::npos);
}

/// Two triangles, bent along their common edge: covered across that edge, four triangles would meet there.
TEST_F(BodyMeshes, ACoverAvoidsEdgesOfTheMesh) {
  for (const double bend : {0.3, -0.3}) {
    const SurfaceMesh bent{{{0, 0, 0}, {1, 0, bend}, {1, 1, 0}, {0, 1, bend}}, {{0, 1, 2}, {0, 2, 3}}};
    const SolidMesh solid = close_mesh(bent);
    ASSERT_EQ(solid.triangles.size(), 4U);
    for (const MeshEdge& e : mesh_edges(solid.triangles)) EXPECT_EQ(e.triangles, 2) << e.a << " " << e.b;
    EXPECT_TRUE(bounds_solid(solid.triangles));
  }
}

TEST_F(BodyMeshes, AdviceOnHolesFitsTheUseAndTheSizeOfTheHole) {
  const std::string large = write("large.obj", obj_of(ball_below(0.85))),
                    small = write("small.obj", obj_of(ball_below(0.99)));
  const std::string vessel = "for a vessel that liquid enters set `inside: true`";
  EXPECT_TRUE(warns_of(set_up(large, false), vessel));
  const drench::Setup with_cloth = set_up(large, true);
  EXPECT_FALSE(warns_of(with_cloth, "inside: true")) << "rejected beside moving cloth";
  EXPECT_TRUE(warns_of(with_cloth, "holes are closed and the inside is solid; a vessel needs walls with a thickness"));
  const drench::Setup tight = set_up(small, false);
  EXPECT_FALSE(warns_of(tight, "inside: true"));
  EXPECT_TRUE(warns_of(tight, "it is small and is closed; the inside is solid"))
      << ::testing::PrintToString(tight.warnings);
  const drench::Setup liquid = built(
      fmt::format("drench: 1\nfluid: {{spacing: 0.1, sources: [{{mesh: {{file: {}}}}}]}}\ndomain: {{min: [-3, -3, -3], "
                  "max: [3, 3, 3]}}\n",
                  large));
  EXPECT_FALSE(warns_of(liquid, "inside: true"));
  EXPECT_TRUE(warns_of(liquid, "fluid: mesh source 0 (" + large + "): the mesh has 1 hole, 1."));
  EXPECT_TRUE(warns_of(liquid, "holes are closed, and the volume inside is filled"));
}

TEST_F(BodyMeshes, TheThicknessOfAVesselIsThatOfItsWalls) {
  // A cup with walls of 0.05 m and a bottom of 1.5 m, in two thirds of its height.
  std::string obj;
  constexpr int around = 24;
  for (const auto& [radius, y] : {std::pair{0.5, 0.0}, {0.5, 4.0}, {0.45, 4.0}, {0.45, 1.5}})
    for (int i = 0; i < around; ++i)
      obj += fmt::format("v {} {} {}\n", radius * std::cos(2 * std::numbers::pi * i / around), y,
                         radius * std::sin(2 * std::numbers::pi * i / around));
  std::string bottom = "f", inner = "f";
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around;
    for (int ring = 0; ring < 3; ++ring)
      obj += fmt::format("f {} {} {} {}\n", ring * around + i + 1, ring * around + next + 1,
                         (ring + 1) * around + next + 1, (ring + 1) * around + i + 1);
    bottom += fmt::format(" {}", around - i);
    inner += fmt::format(" {}", 3 * around + i + 1);
  }
  const drench::Setup cup = set_up(write("cup.obj", obj + bottom + "\n" + inner + "\n"), false);
  EXPECT_TRUE(warns_of(cup, "bodies.0: its median thickness 0.0")) << ::testing::PrintToString(cup.warnings);
  EXPECT_TRUE(warns_of(cup, "is 0.5 spacings: liquid interacts through it")) << ::testing::PrintToString(cup.warnings);
}

TEST_F(BodyMeshes, TheFieldOfALargeOneCoversTheDomainOnly) {
  const std::string ball = write("ball.obj", obj_of(test::ball_mesh(3)));
  const auto large = [&](const std::string& more) {
    return built(fmt::format(
        "drench: 1\nfluid: {{spacing: 0.1, sources: [{{block: {{min: [-0.5, 0, -0.5], max: [0.5, 0.5, 0.5]}}}}]}}\n"
        "domain: {{min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}}\n"
        "bodies: [{{mesh: {{file: {}, scale: 4, position: [0, -4, 0]{}}}}}]\n",
        ball, more));
  };
  const drench::Setup still = large(""), moving = large(", velocity: [0.1, 0, 0]");
  const DistanceField &clipped = still.model.bodies[0].field, &whole = moving.model.bodies[0].field;
  EXPECT_LT(20 * clipped.value.size(), whole.value.size());
  for (const Vec3& x : {Vec3{0, 0.3, 0}, {0.4, 0.1, -0.3}, {0.1, -0.4, 0.2}, {-0.5, -0.5, 0.5}}) {
    Vec3 normal, expected_normal;
    const double distance = field_distance(clipped, x, normal), expected = field_distance(whole, x, expected_normal);
    EXPECT_NEAR(distance, expected, 0.002);
    EXPECT_LT((to_eigen(normal) - to_eigen(expected_normal)).norm(), 0.02);
  }
  EXPECT_EQ(still.model.boundary.count() > 0, true);
}

TEST_F(BodyMeshes, ASheetHoldsLiquidAndIsRefusedToClothWithItsPlace) {
  const std::string file = write("sheet.obj", "v 0 0 0\nv 0.4 0 0\nv 0.4 0 0.2\nv 0 0 0.2\nf 1 2 3 4\n");
  EXPECT_TRUE(warns_of(set_up(file, false),
                       "it encloses no volume: only the boundary particles on its surface hold liquid back"));
  const std::string text = refusal(file, true);
  EXPECT_NE(text.find("encloses no volume: its edge, 0.4 m across at (0.2, 0, 0.1)"), std::string::npos) << text;
  EXPECT_NE(text.find("give the sheet a thickness"), std::string::npos) << text;
}

TEST_F(BodyMeshes, TurnedRepeatedCutAndBranchingOnesAreTheSameSolid) {
  const TestMesh ball = test::ball_mesh(2);
  TestMesh inverted = ball, mixed = ball, twice = ball, soup, sliver = ball;
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
    const auto [a, b, c] = ball.triangles[t];
    std::swap(inverted.triangles[t][0], inverted.triangles[t][1]);
    if (t % 3 == 0) std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
    twice.triangles.push_back({b, a, c});
    for (const int k : {a, b, c}) soup.points.push_back(ball.points[static_cast<std::size_t>(k)]);
    const int n = static_cast<int>(3 * t);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  const auto [a, b, c] = ball.triangles[0];  // a point almost on an edge, in both of its triangles
  sliver.points.push_back(0.5 * (ball.points[static_cast<std::size_t>(a)] + ball.points[static_cast<std::size_t>(b)]) *
                          (1 + 1e-14));
  const int middle = static_cast<int>(sliver.points.size()) - 1;
  sliver.triangles.push_back({a, middle, b});
  sliver.triangles[0] = {middle, b, c};
  sliver.triangles.push_back({a, middle, c});
  const auto expected = exact_distance(solid_of(ball));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  for (const TestMesh& mesh : {inverted, mixed, twice, soup, sliver}) {
    const Body body = solid_of(mesh);
    EXPECT_TRUE(is_closed({body.mesh_points, body.mesh_triangles}));
    const auto distance = exact_distance(body);
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 x{uniform(random), uniform(random), uniform(random)};
      EXPECT_NEAR(distance(x), expected(x), 1e-12);
    }
  }
  // A wall within a box, and two boxes that share an edge and its points.
  TestMesh walled = box_mesh({0, 0, 0}, {1, 1, 1});
  walled.triangles.push_back({0, 3, 7});
  walled.triangles.push_back({0, 7, 4});
  TestMesh edge = box_mesh({0, 0, 0}, {1, 1, 1});
  for (const Vector3d& x : {Vector3d(2, 1, 0), Vector3d(1, 2, 0), Vector3d(2, 2, 0), Vector3d(2, 1, 1),
                            Vector3d(1, 2, 1), Vector3d(2, 2, 1)})
    edge.points.push_back(x);
  const int corner[8] = {3, 8, 9, 10, 7, 11, 12, 13};
  for (const auto& t : box_mesh({0, 0, 0}, {1, 1, 1}).triangles)
    edge.triangles.push_back({corner[t[0]], corner[t[1]], corner[t[2]]});
  for (const TestMesh& mesh : {walled, edge}) {
    const SurfaceMesh surface = surface_of(mesh);
    const SolidMesh solid = close_mesh(surface);
    EXPECT_GT(solid.branches, 0u);
    const Body body = body_of(solid, surface);
    EXPECT_TRUE(bounds_solid(body.mesh_triangles));
    const auto distance = exact_distance(body);
    EXPECT_NEAR(distance({0.5, 0.5, 0.9}), -0.1, 1e-12);
    EXPECT_NEAR(distance({0.5, 0.5, 1.25}), 0.25, 1e-12);
  }
  EXPECT_LT(exact_distance(solid_of(edge))({1.5, 1.5, 0.5}), -0.49);
  EXPECT_NEAR(exact_distance(solid_of(edge))({1.5, 0.5, 0.5}), 0.5, 1e-12);
}

TEST_F(BodyMeshes, TheWindingNumberIsInsideAsVtkSaysIt) {
  TestMesh mesh = test::ball_mesh(3);
  for (Vector3d& x : mesh.points) x *= 1 + 0.4 * std::sin(5 * x[0] + 3 * x[1]) * std::cos(4 * x[2]);
  const Body body = solid_of(mesh);
  const WindingNumber winding(body.mesh_points, body.mesh_triangles);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& x : body.mesh_points) points->InsertNextPoint(x.data());
  vtkNew<vtkCellArray> cells;
  for (const auto& t : body.mesh_triangles) cells->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(cells);
  vtkNew<vtkSelectEnclosedPoints> vtk;
  vtk->Initialize(surface);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  int inside = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec3 x{uniform(random), uniform(random), uniform(random)};
    EXPECT_EQ(winding.around(x), vtk->IsInsideSurface(x[0], x[1], x[2]));
    inside += winding.around(x);
  }
  EXPECT_GT(inside, 300);
  // Lines through points and edges of the mesh, as lattices have them.
  const Body box = solid_of(box_mesh({0, 0, 0}, {1, 1, 1}));
  const WindingNumber of_box(box.mesh_points, box.mesh_triangles);
  for (int i = -2; i < 7; ++i)
    for (int j = -2; j < 7; ++j)
      for (int k = -2; k < 7; ++k) {
        const Vec3 x{0.25 * i + 0.01, 0.25 * j, 0.25 * k};
        const bool on_edge = j == 0 || j == 4 || k == 0 || k == 4;
        const int expected = i >= 0 && i < 4 && j > 0 && j < 4 && k > 0 && k < 4;
        if (on_edge && i >= 0 && i < 4) continue;
        EXPECT_EQ(of_box.around(x), expected) << i << " " << j << " " << k;
      }
}

TEST_F(BodyMeshes, AFieldHasTheSameBitsOnAnyNumberOfThreads) {
  Body body = solid_of(ball_below(0.5));
  body.field = lay_field(body, 0.06, 0.1);
  fill_field(body, body.field, 1);
  const auto one = body.field.value;
  for (const int threads : {2, 3, 7}) {
    fill_field(body, body.field, threads);
    EXPECT_EQ(body.field.value, one);
  }
}

TEST_F(BodyMeshes, CheckTakesThreads) {
  write("open.obj", obj_of(ball_below(0.85)));
  write("scene.yaml",
        "drench: 1\ncloth: [{mesh: {grid: {size: [1, 1], nodes: [5, 5]}}, place: {position: [0, 2, 0]}}]\n"
        "bodies: [{mesh: {file: open.obj}}]\n");
  const test::Outcome checked = test::run_drench(folder_, {"check", "scene.yaml", "--threads", "2"});
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_NE(checked.out.find("the mesh has 1 hole"), std::string::npos) << checked.out;
}

/// A tetrahedron; `inwards`: with all faces turned the wrong way, one of them twice; `partly`: with a corner without.
TEST_F(BodyMeshes, KeepTheTextureOfTheirCorners) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 0.5 0\nvt 0 0.5\nvt 0.5 0.5\n";
  const std::string outwards = points + "f 1/1 3/3 2/2\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n",
                    inwards = points + "f 1/1 2/2 3/3\nf 1/1 4/4 2/2\nf 1/1 4/4 2/2\nf 1/1 3/3 4/4\nf 2/2 4/4 3/3\n",
                    partly = points + "f 1/1 3/3 2\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n";
  const auto texture_of = [&](const std::string& name, const std::string& text, std::size_t untextured) {
    BodyScene scene;
    scene.kind = BodyScene::Kind::mesh;
    scene.file = write(name, text);
    const Body body = make_body(scene, "", "bodies.0", nullptr, MeshUse::solid);
    std::size_t found = 0;
    const TextureCorners texture = body_texture(scene, "", found);
    EXPECT_EQ(found, untextured) << name;
    // u, v are half of x + z, y + z: those of the point, whichever way its triangle is turned.
    for (std::size_t t = 0; t < texture.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3& x = body.mesh_points[static_cast<std::size_t>(body.mesh_triangles[t][c])];
        EXPECT_EQ(texture[t][c][0], 0.5 * (x[0] + x[2])) << name << t;
        EXPECT_EQ(texture[t][c][1], 0.5 * (x[1] + x[2])) << name << t;
      }
    return texture.size();
  };
  EXPECT_EQ(texture_of("out.obj", outwards, 0), 4U);
  EXPECT_EQ(texture_of("in.obj", inwards, 0), 4U) << "a face that is there twice is left out";
  EXPECT_EQ(texture_of("partly.obj", partly, 1), 0U);
}

}  // namespace
}  // namespace drench::testing
