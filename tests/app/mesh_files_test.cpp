// Mesh files: read as cloths and as bodies, and the ones that are refused.

#include <gtest/gtest.h>
#include <vtkCell.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <vtkSphereSource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <random>

#include "base/eigen_vec.hpp"
#include "mesh_folder.hpp"
#include "setup/build.hpp"
#include "setup/mesh_io.hpp"

namespace drench::testing {
namespace {

/// Writes a triangulated surface as `name`.obj, .ply and .stl.
void write_every_format(vtkPolyData* surface, const std::filesystem::path& name) {
  std::string obj = "v 9 9 9\n";  // a point that no triangle uses
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p) {
    const double* x = surface->GetPoint(p);
    obj += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
  }
  for (vtkIdType c = 0; c < surface->GetNumberOfPolys(); ++c) {
    obj += "f";
    for (int k = 0; k < 3; ++k) obj += " " + std::to_string(surface->GetCell(c)->GetPointId(k) + 2);
    obj += "\n";
  }
  std::ofstream(name.string() + ".obj") << obj;
  vtkNew<vtkPLYWriter> ply;
  ply->SetFileName((name.string() + ".ply").c_str());
  ply->SetInputData(surface);
  ply->Write();
  vtkNew<vtkSTLWriter> stl;
  stl->SetFileName((name.string() + ".stl").c_str());
  stl->SetFileTypeToBinary();
  stl->SetInputData(surface);
  stl->Write();
}

/// Samples half a spacing below the surface, none too close, none of that surface far from one.
void expect_even_samples(const std::vector<Vec3>& x, const Body& made) {
  for (const double r : nearest_distances(x)) {
    EXPECT_GE(r, 0.7 * d);
    EXPECT_LE(r, 1.5 * d);
  }
  const auto at = [&](Index i) { return to_eigen(made.mesh_points[static_cast<std::size_t>(i)]); };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const auto& t : made.mesh_triangles) {
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    Eigen::Vector3d p = at(t[0]) + u * (at(t[1]) - at(t[0])) + v * (at(t[2]) - at(t[0]));
    p -= 0.5 * d * (p - to_eigen(made.center)).normalized();
    double nearest = 1;
    for (const Vec3& s : x) nearest = std::min(nearest, (p - to_eigen(s)).norm());
    EXPECT_LE(nearest, d);
  }
  double inner = 0.3;  // radius of the mesh's inscribed ball
  for (const auto& t : made.mesh_triangles) {
    const Eigen::Vector3d across = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalized();
    inner = std::min(inner, std::abs(across.dot(at(t[0]) - to_eigen(made.center))));
  }
  for (const Vec3& p : x) {
    EXPECT_GT((to_eigen(p) - to_eigen(made.center)).norm(), inner - 0.55 * d);
    EXPECT_LT((to_eigen(p) - to_eigen(made.center)).norm(), 0.3 - 0.45 * d);
  }
}

/// Liquid is left out inside, and nowhere else.
void expect_inside_told_from_outside(const drench::Setup& setup, const Body& made) {
  const auto at = [&](Index i) { return to_eigen(made.mesh_points[static_cast<std::size_t>(i)]); };
  double volume = 0;
  for (const auto& t : made.mesh_triangles) volume += at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6;
  const double removed = 50 * 40 * 40 - setup.state.fluid_count();
  EXPECT_NEAR(removed * d * d * d / volume, 1, 0.01);
  for (const Vec3& p : setup.state.fluid_position) EXPECT_GT((to_eigen(p) - to_eigen(made.center)).norm(), 0.29);
}

class MeshFiles : public MeshFolder {};

TEST_F(MeshFiles, RoundTripsThroughEveryFormat) {
  vtkNew<vtkSphereSource> source;
  source->SetRadius(0.2);
  source->SetThetaResolution(24);
  source->SetPhiResolution(14);
  source->Update();
  vtkPolyData* sphere = source->GetOutput();
  const auto triangles = static_cast<std::size_t>(sphere->GetNumberOfPolys());
  const auto points = static_cast<std::size_t>(sphere->GetNumberOfPoints());
  write_every_format(sphere, folder_ / "ball");
  for (const std::string name : {"ball.obj", "ball.ply", "ball.stl"}) {
    const SurfaceMesh mesh = read_mesh(name, (folder_ / "scene.yaml").string());  // found beside the scene
    EXPECT_EQ(mesh.points.size(), points) << name;
    EXPECT_EQ(mesh.triangles.size(), triangles) << name;
    EXPECT_TRUE(is_closed(mesh)) << name;
    for (const Vec3& x : mesh.points) EXPECT_NEAR(to_eigen(x).norm(), 0.2, 2e-6) << name;
  }

  // As a body: its samples, its inside, its spin.
  Scene scene = wet_scene();
  scene.path = (folder_ / "scene.yaml").string();
  BodyScene body;
  body.kind = BodyScene::Kind::mesh;
  body.file = "ball.stl";
  body.scale = 1.5;
  body.position = {0.1, 0, 0};
  body.spin = {{0, 2, 0}, 90};
  scene.bodies.push_back(body);
  scene.fluid.blocks.push_back({{{-0.4, -0.4, -0.4}, {0.6, 0.4, 0.4}}, {0, 0, 0}});
  const drench::Setup setup = build(scene);
  const Body& made = setup.model.bodies[0];
  EXPECT_NEAR(to_eigen(made.center).x(), 0.1, 1e-6);
  EXPECT_NEAR(made.spin_rate.plain(), std::numbers::pi / 2, 1e-15);
  const auto& x = setup.model.boundary.position;
  expect_even_samples(x, made);
  expect_inside_told_from_outside(setup, made);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector3d expected =
        made.spin_rate.plain() * Eigen::Vector3d(0, 1, 0).cross(to_eigen(x[i]) - to_eigen(made.center));
    EXPECT_LT((to_eigen(setup.state.boundary_velocity[i]) - expected).norm(), 1e-12);
  }
}

TEST_F(MeshFiles, ClothFromAFileWithPolygonsAndSeams) {
  // Two squares with different texture coordinates along their common side: still one sheet.
  const std::string path = write("sheet.obj",
                                 "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0 1\nv 1 0 1\nv 2 0 1\n"
                                 "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
                                 "f 1/1 4/3 5/4 2/2\nf 2/1 5/3 6/4 3/2\n");
  Scene scene;
  ClothScene cloth;
  cloth.name = "sheet";
  cloth.file = path;
  cloth.scale = 0.5;
  cloth.pins.emplace_back().kind = PinScene::Kind::edges;
  scene.cloths.push_back(cloth);
  const Model m = build(scene).model;
  EXPECT_EQ(m.mesh.nodes(), 6);
  EXPECT_EQ(m.mesh.triangles(), 4);
  EXPECT_EQ(m.mesh.hinge.size(), 3u);
  EXPECT_EQ(std::count(m.mesh.pinned.begin(), m.mesh.pinned.end(), 1), 6);
  double mass = 0;
  for (const double v : m.mesh.solid_mass) mass += v;
  EXPECT_NEAR(mass, 0.2 * 0.5, 1e-8);
  scene.cloths[0].pins[0].kind = PinScene::Kind::corners;
  EXPECT_NE(error_of(scene).find("a mesh file has no corners"), std::string::npos);
}

TEST_F(MeshFiles, TheWarpRunsAlongTheTextureOrAsTheSceneSays) {
  // Two squares, the texture's v along z in the first and along x in the second.
  const std::string points = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0 1\nv 1 0 1\nv 2 0 1\nv 0 1 0\n",
                    texture = "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n";
  const std::string path = write("pieces.obj", points + texture + "f 1/1 4/3 5/4 2/2\nf 2/1 5/2 6/4 3/3\n");
  Scene scene;
  ClothScene cloth;
  cloth.file = path;
  cloth.material.porous = true;
  cloth.material.weft_diffusivity = 2.0e-5;
  cloth.rotate_axis = {0, 1, 0};
  cloth.rotate_degrees = 90;  // z to x, x to −z
  scene.cloths.push_back(cloth);
  const auto expect_warp = [&](std::size_t triangle, const Vec3& expected) {
    const Model m = build(scene).model;
    ASSERT_EQ(m.mesh.triangle_warp.size(), 4u);
    EXPECT_LT((to_eigen(m.mesh.triangle_warp[triangle]) - to_eigen(expected)).norm(), 1e-12);
  };
  for (const std::size_t t : {0u, 1u}) expect_warp(t, {1, 0, 0});
  for (const std::size_t t : {2u, 3u}) expect_warp(t, {0, 0, -1});
  MaterialScene& fabric = scene.cloths[0].material;
  fabric.has_warp = true;
  fabric.warp = {2, 5, 0};  // its part in the plane y = 0
  for (std::size_t t = 0; t < 4; ++t) expect_warp(t, {0, 0, -1});

  const auto expect_error = [&](const std::string& part) {
    EXPECT_NE(error_of(scene).find(part), std::string::npos) << error_of(scene);
  };
  fabric.warp = {0, 1, 0};
  expect_error("triangle 0 lies across the direction of warp");
  fabric.has_warp = false;
  scene.cloths[0].file = write("plain.obj", points + "f 1 4 5\nf 1 5 2\n");
  expect_error("has no texture coordinates, which give the warp direction; allowed: an .obj that has them, or the key");
  scene.cloths[0].file = write("creased.obj", points + texture + "f 1/1 4/3 5/4\nf 1/1 5/1 2/2\n");
  expect_error("triangle 1 has no area in the file's texture");
}

TEST_F(MeshFiles, AnObjFileKeepsItsPointsWhateverItsCornersName) {
  const std::string points = "v 0.1 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 1 0\n";
  for (const std::string faces :
       {"f 1 2 3\nf 2 4 3\n", "f 1/1 2/2 3/3\nf 2/1 4/2 3/3\n", "f 1//1 2//1 3//1\nf 2 4 3\n",
        "usemtl a\nf 1/1/1 2/2/1 3/3/1\nusemtl b\nf 2//1 4//1 3//1\n", "f 1 2 3 # a comment\r\nf -3 -1 \\\r\n-2\r\n",
        "# C:\\models\\\r\nf 1/ 2// 3\r\n# x\\\nf\t2 4 3 \n", "vt 0.5\nvt nan nan\nf 1 2 3\nf 2 4 3"}) {
    const SurfaceMesh mesh = read_mesh(write("corners.obj", "\xef\xbb\xbf" + points + faces), "", {.texture = true});
    SCOPED_TRACE(faces);
    ASSERT_EQ(mesh.points.size(), 4u);
    EXPECT_EQ(mesh.points[0], (Vec3{0.1, 0, 0})) << "in double precision";
    EXPECT_EQ(mesh.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}, {1, 3, 2}}));
    std::vector<std::array<std::array<double, 2>, 3>> texture;  // of triangles whose corners all have one
    if (faces.starts_with("f 1/1")) texture = {{{{0, 0}, {1, 0}, {0, 1}}}, {{{0, 0}, {1, 0}, {0, 1}}}};
    EXPECT_EQ(mesh.texture, texture);
  }
}

TEST_F(MeshFiles, NamesStayWithTheirFacesWhateverTheLineEnds) {
  const std::string points = "v 0 0 0\r\nv 1 0 0\r\nv 0 0 1\r\nv 1 0 1\r\n# C:\\models\\\r\n";
  const std::string file = write("named.obj", points + "g a \\\r\nb\r\nf 1 2 3\r\no c # no name\r\ng\r\nf 2 4 3\r\n");
  const SurfaceMesh mesh = read_mesh(file, "", {.groups = true});
  EXPECT_EQ(mesh.groups, (std::map<std::string, std::vector<Index>>{{"a", {0}}, {"b", {0}}, {"c", {1}}}));
}

/// The numbers of a binary file, the first byte first.
template <class... T>
std::string packed(T... values) {
  std::string bytes;
  const auto add = [&](const auto& value) {
    std::string one(sizeof value, '\0');
    std::memcpy(one.data(), &value, sizeof value);
    bytes += one;
  };
  (add(values), ...);
  return bytes;
}

TEST_F(MeshFiles, PlyFilesOfManyProgramsAreTheSameMesh) {
  const std::string xyz = "property double x\nproperty double y\nproperty double z\n";
  const auto ascii = [&](const std::string& before, const std::string& vertex, const std::string& list,
                         const std::string& after) {
    return "ply\nformat ascii 1.0\ncomment a b\n" + before + "element vertex 4\n" + vertex +
           "element face 2\nproperty list uchar " + list + "\n" + after + "end_header\n";
  };
  const std::string points = "0.1 0 0\n1 0 0\n0 0 1\n1 0 1\n", faces = "3 0 1 2\n3 1 3 2\n";
  std::string windows = ascii("", xyz, "int vertex_indices", "") + points + faces;
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) windows.insert(at, "\r");
  const std::string header = ascii("", xyz, "uint vertex_index", "");
  const auto binary = [&](const std::string& format) {
    return std::string(header).replace(header.find("ascii"), 5, format);
  };
  const auto numbers = [&](bool swapped) {
    std::string bytes;
    const auto add = [&](std::string one) { bytes += swapped ? std::string(one.rbegin(), one.rend()) : one; };
    for (const double x : {0.1, 0., 0., 1., 0., 0., 0., 0., 1., 1., 0., 1.}) add(packed(x));
    for (const std::array<unsigned, 3>& t : {std::array{0u, 1u, 2u}, std::array{1u, 3u, 2u}}) {
      bytes += '\3';
      for (const unsigned p : t) add(packed(p));
    }
    return bytes;
  };
  const std::vector<std::string> files = {
      ascii("", xyz, "int vertex_indices", "") + points + faces,
      ascii("", xyz, "int vertex_indices", "") + points + faces.substr(0, faces.size() - 1),  // no end of the last line
      windows,
      ascii("element camera 1\nproperty float view\n", xyz, "int vertex_index", "element edge 1\nproperty int a\n") +
          "7\n" + points + "\n" + faces + "5\n",
      ascii("", "property list uchar float more\n" + xyz, "int vertex_indices", "") +
          "0 0.1 0 0\n2 5 5 1 0 0\n1 3 0 0 1\n0 1 0 1\n" + faces,
      ascii("", xyz, "int vertex_indices", "property list uchar float texcoord\n") + points +
          "3 0 1 2 6 0 0 1 0 0 1\n3 1 3 2 6 9 9 8 8 7 7\n",
      binary("binary_little_endian") + numbers(false),
      binary("binary_big_endian") + numbers(true)};
  for (std::size_t k = 0; k < files.size(); ++k) {
    SCOPED_TRACE(k);
    const SurfaceMesh mesh = read_mesh(write("same.ply", files[k]), "", {.texture = true});
    ASSERT_EQ(mesh.points.size(), 4u);
    EXPECT_EQ(mesh.points[0], (Vec3{0.1, 0, 0})) << "in double precision";
    EXPECT_EQ(mesh.triangles, (std::vector<std::array<Index, 3>>{{0, 1, 2}, {1, 3, 2}}));
    ASSERT_EQ(mesh.texture.size(), k == 5 ? 2u : 0u);
    for (const auto& uv : mesh.texture)
      EXPECT_EQ(uv[2], (uv == mesh.texture[0] ? std::array<double, 2>{0, 1} : std::array<double, 2>{7, 7}));
  }
}

TEST_F(MeshFiles, StlFilesOfManyProgramsAreTheSameMesh) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const std::string triangle =
      packed(0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f) + std::string(2, '\0');
  std::string head = "solid by a program";
  head.resize(80);
  for (const std::string& file :
       {"solid\n" + facet + "endsolid\n", "SOLID x\r\n" + facet + "endsolid x\r\n",
        "\nsolid caf\xc3\xa9\n" + facet + "endsolid\n", std::string(80, ' ') + packed(1u) + triangle,
        head + packed(1u) + triangle + "more", head + packed(0xffffffffu) + triangle}) {
    const SurfaceMesh mesh = read_mesh(write("same.stl", file), "");
    EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})) << file;
  }
}

TEST_F(MeshFiles, BadOnesAreRefused) {
  const auto error = [&](const std::string& name, const std::string& text) {
    Scene scene;
    ClothScene cloth;
    cloth.file = text.empty() ? name : write(name, text);
    scene.cloths.push_back(cloth);
    return error_of(scene);
  };
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nv 0 -1 0\nv 2 0 0\n";
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? ::testing::AssertionSuccess() : ::testing::AssertionFailure() << text;
  };
  EXPECT_TRUE(has(error("nowhere.obj", ""), "no such file"));
  EXPECT_TRUE(has(error("a.off", points + "f 1 2 3\n"), "unknown extension"));
  EXPECT_TRUE(has(error("empty.obj", points), "it holds no triangles"));
  EXPECT_TRUE(has(error("flat.obj", points + "v 0.5 0 1e-7\nf 1 2 3\nf 1 2 7\n"),
                  "triangle 1 of the mesh (points 0, 1, 3) is degenerate"));
  EXPECT_TRUE(
      has(error("line.obj", points + "f 1 2 6\n"),
          "it holds no triangles: all its faces have no area or name a point twice; it belongs to face 0 (line 7)"));
  EXPECT_EQ(error("fan.obj", points + "f 1 2 3\nf 1 2 4\nf 1 2 5\n"), "");  // held together by stitches
  EXPECT_EQ(error("twice.obj", points + "f 1 2 3\nf 1 3 2\n"), "");         // read once
  EXPECT_TRUE(has(error("junk.ply", "this is not a mesh\n"), "cannot be read: "));
  EXPECT_TRUE(has(error("junk.stl", "this is not a mesh\n"), "cannot be read: "));
  EXPECT_TRUE(has(error("range.obj", points + "f 1 2 99\n"), "line 7: there is no point 99, 6 are defined so far"));
  EXPECT_TRUE(has(error("next.obj", points + "f 1 2 \\\n3 99\n"), "there is no point 99"));
  EXPECT_EQ(error("last.obj", points + "f -6 -5 -4\n"), "");  // counted from the end
  EXPECT_TRUE(has(error("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"), "line 1: a point needs three finite"));
  EXPECT_TRUE(has(error("texture.obj", points + "vt 0 0\nf 1 2/3/14 3\n"), "line 8: there is no texture coordinate 3"));
  EXPECT_EQ(error("no_texture.obj", points + "f 1/1/1 2/2/1 3/3/1\n"), "");
  EXPECT_TRUE(has(error("corner.obj", points + "f 1 2x 3\n"), "line 7: '2x' is not a corner of a face"));
  EXPECT_TRUE(has(error("two.obj", points + "f 1 2\n"), "line 7: a face needs three corners"));
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = ply;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(error("good.ply", ply + "0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n"), "");
  EXPECT_TRUE(has(error("range.ply", ply + "0 0 0\n1 0 0\n0 0 1\n3 0 1 7\n"), "face 0: there is no point 7"));
  EXPECT_TRUE(
      has(error("nan.ply", ply + "0 0 0\n1 nan 0\n0 0 1\n3 0 1 2\n"), "point 1 of the mesh is not a finite number"));
  EXPECT_TRUE(has(error("short.ply", ply + "0 0 0\n1 0\n0 0 1\n3 0 1 2\n"), "line 11: vertex 1 has too few numbers"));
  EXPECT_TRUE(has(error("word.ply", ply + "0 0 0\n1 x 0\n0 0 1\n3 0 1 2\n"), "line 11: 'x' of vertex 1 is no number"));
  EXPECT_TRUE(has(error("ends.ply", ply + "0 0 0\n1 0 0\n"), "it ends in vertex 2 of 3"));
  EXPECT_TRUE(has(error("endless.ply", "ply\nformat ascii 1.0\n"), "its header has no end"));
  EXPECT_TRUE(has(error("vast.ply", changed("vertex 3", "vertex 3000000000") + "0 0 0\n"),
                  "line 3: there cannot be 3000000000 of 'vertex'"));
  EXPECT_TRUE(has(error("list.ply", changed("vertex_indices", "corners") + "0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n"),
                  "its element 'face' has no list 'vertex_indices'"));
  EXPECT_TRUE(has(error("binary.ply", changed("ascii", "binary_little_endian") + std::string(36, '\0') + "\3"),
                  "it ends in face 0 of 1"));
  EXPECT_TRUE(
      has(error("whole.ply", ply + "0 0 0\n1 0 0\n0 0 1\n3e0 0 1 2\n"), "line 13: '3e0' of face 0 is no whole number"));
  EXPECT_TRUE(has(error("nan.stl",
                        "solid\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 1 "
                        "0\nendloop\nendfacet\nendsolid\n"),
                  "line 4: a vertex needs three finite numbers"));
  EXPECT_TRUE(has(error("bare.stl", "facet normal 0 0 1\n"), "line 1: expected 'solid', found 'facet'"));
  EXPECT_TRUE(has(error("cut.stl", std::string(80, '\0') + "\3" + std::string(60, '\0')),
                  "its header gives 3 triangles, but its size allows 1"));
  EXPECT_TRUE(has(error("vast.stl", std::string(80, '\0') + std::string("\x00\x28\x6b\xee", 4) + std::string(60, '\0')),
                  "its header gives 4000000000 triangles, but its size allows 1"));
}

TEST_F(MeshFiles, WithOtherContentsOrCutOffNameTheReason) {
  const auto error = [&](const std::string& name, const std::string& text) {
    try {
      read_mesh(write(name, text), "");
    } catch (const SetupError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const struct {
    const char* name;
    std::string text, why;
  } files[] = {
      {"lfs.obj", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
       "it is a Git LFS pointer, not the mesh: run git lfs pull"},
      {"page.stl", "\n<!DOCTYPE html>\n<html></html>\n", "it is a web page, not a mesh"},
      {"scene.obj", "<?xml version=\"1.0\"?>\n<COLLADA/>\n", "it is XML, such as COLLADA (.dae): convert it to .obj"},
      {"scene.ply", std::string("glTF\2\0\0\0", 8), "it is binary glTF"},
      {"none.stl", "", "it is empty"},
      {"text.stl", "# a comment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
       "its content is of the format .obj, not .stl: rename it to .obj"},
      {"text.ply", "solid a\n" + facet + "endsolid a\n", "its content is of the format .stl, not .ply"},
      {"binary.obj", std::string(80, '\0') + std::string("\1\0\0\0", 4) + std::string(50, '\0'),
       "its content is of the format .stl, not .obj"},
      {"names.stl", "ply\nformat ascii 1.0\n", "its content is of the format .ply, not .stl"},
      {"points.obj", "v 0 0 0\nv 1 0 0\n", "it holds no triangles: 2 points, but no faces; is the file complete?"},
      {"noise.obj", "nothing of a mesh\n", "it holds no triangles: no points or faces were found in it"},
      {"open.stl", "solid a\n" + facet + facet, "line 16: the text ends before 'endsolid': the file is incomplete"},
      {"half.stl", "solid a\n" + facet + facet.substr(0, 43), "line 12: expected 'vertex', but the text ends"},
  };
  for (const auto& [name, text, why] : files) {
    const std::string found = error(name, text);
    EXPECT_NE(found.find(why), std::string::npos) << name << ": " << found;
    EXPECT_EQ(found.find('\n'), std::string::npos) << found;
    EXPECT_LT(found.size(), 300U) << found;
  }
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  for (const char* end : {"\n", ""})  // many programs write no line break at the end
    EXPECT_EQ(read_mesh(write("whole.obj", corners + "f 1 2 3\nf 2 4 3" + end), "").left_out, "");
  EXPECT_EQ(read_mesh(write("two.stl", "solid a\n" + facet + "endsolid a\nSOLID b\n" + facet + "endsolid"), "")
                .triangles.size(),
            2U);
  std::string binary = std::string(80, '\0') + std::string("\1\0\0\0", 4);
  const float numbers[] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string triangle =
      std::string(reinterpret_cast<const char*>(numbers), sizeof numbers) + std::string(2, '\0');
  EXPECT_EQ(read_mesh(write("one.stl", binary + triangle), "").left_out, "");
  EXPECT_NE(read_mesh(write("more.stl", binary + triangle + triangle), "")
                .left_out.find("its header gives 1 triangle, but its size allows 2; is the file complete?"),
            std::string::npos);
}

TEST_F(MeshFiles, FarFromTheOriginAreRejectedWithTheVertex) {
  Scene scene;
  ClothScene cloth;
  cloth.file = write("far.obj", "v 1e30 0 0\nv 0 1e30 0\nv 0 0 1e30\nf 1 2 3\n");
  scene.cloths.push_back(cloth);
  const std::string text = error_of(scene);
  EXPECT_NE(text.find("point 0 of the mesh is at (1e+30, 0, 0) m; allowed: coordinates from -100000 to 100000 m; check "
                      "the file, unit and scale"),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace drench::testing
