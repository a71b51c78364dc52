#pragma once
// Irregular meshes of rectangles, as a mesher makes them.

#include <vtkCellArray.h>
#include <vtkDelaunay2D.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <random>
#include <string>
#include <vector>

#include "app/run_program.hpp"
#include "base/eigen_vec.hpp"
#include "setup/surface_mesh.hpp"

namespace drench::test {

inline std::vector<std::array<Index, 3>> delaunay(const std::vector<Vec3>& points) {
  vtkNew<vtkPoints> flat;
  flat->SetDataTypeToDouble();
  for (const Vec3& x : points) flat->InsertNextPoint(x[0], x[2], 0);
  vtkNew<vtkPolyData> input;
  input->SetPoints(flat);
  vtkNew<vtkDelaunay2D> filter;
  filter->SetInputData(input);
  filter->Update();
  std::vector<std::array<Index, 3>> triangles;
  vtkCellArray* cells = filter->GetOutput()->GetPolys();
  vtkNew<vtkIdList> ids;
  for (cells->InitTraversal(); cells->GetNextCell(ids);) {
    std::array<Index, 3> t;
    for (int c = 0; c < 3; ++c) t[static_cast<std::size_t>(c)] = static_cast<Index>(ids->GetId(c));
    triangles.push_back(t);
  }
  return triangles;
}

/// Delaunay's triangles of `fixed` points and of `free` ones, each moved `passes` times to the mean of its triangles.
inline SurfaceMesh smoothed_mesh(const std::vector<Vec3>& fixed, const std::vector<Vec3>& free, int passes) {
  SurfaceMesh mesh;
  mesh.points = fixed;
  mesh.points.insert(mesh.points.end(), free.begin(), free.end());
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<Eigen::Vector3d> moment(mesh.points.size(), Eigen::Vector3d::Zero());
    std::vector<double> weight(mesh.points.size(), 0);
    for (const auto& t : delaunay(mesh.points)) {
      Eigen::Vector3d center = Eigen::Vector3d::Zero();
      for (const Index c : t) center += to_eigen(mesh.points[static_cast<std::size_t>(c)]) / 3;
      const double area =
          triangle_area(mesh.points[std::size_t(t[0])], mesh.points[std::size_t(t[1])], mesh.points[std::size_t(t[2])]);
      for (const Index c : t) {
        moment[static_cast<std::size_t>(c)] += area * center;
        weight[static_cast<std::size_t>(c)] += area;
      }
    }
    for (std::size_t i = fixed.size(); i < mesh.points.size(); ++i) mesh.points[i] = to_vec3(moment[i] / weight[i]);
  }
  mesh.triangles = delaunay(mesh.points);
  return mesh;
}

/// A strip in x from `from` to `to` and in z from 0 to `width`, with edges of `size` on its boundary and on the line x
/// = 0.
inline SurfaceMesh irregular_strip(double from, double to, double width, double size, int passes) {
  const auto parts = [&](double length) { return std::max(1, static_cast<int>(std::lround(length / size))); };
  std::vector<Vec3> fixed, free;
  const int across = parts(width), along = parts(to - from);
  for (int j = 0; j <= across; ++j)
    for (const double x : {from, to}) fixed.push_back({x, 0, width * j / across});
  for (int j = 1; from < -0.5 * size && j < across; ++j) fixed.push_back({0, 0, width * j / across});
  for (int i = 1; i < along; ++i)
    for (const double z : {0.0, width}) fixed.push_back({from + (to - from) * i / along, 0, z});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(from + 0.5 * size, to - 0.5 * size), z(0.5 * size, width - 0.5 * size);
  for (int k = 0; k < (across - 1) * (along - 1); ++k) {
    const Vec3 point{x(random), 0, z(random)};
    if (std::fabs(point[0]) > 0.4 * size) free.push_back(point);
  }
  return smoothed_mesh(fixed, free, passes);
}

/// The mesh as a file in `folder`; its name.
inline std::string write_obj(const TempFolder& folder, const SurfaceMesh& mesh) {
  std::string obj;
  for (const Vec3& x : mesh.points) obj += fmt::format("v {} {} {}\n", x[0], x[1], x[2]);
  for (const auto& t : mesh.triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  write_text(folder.path() / "sheet.obj", obj);
  return (folder.path() / "sheet.obj").string();
}

}  // namespace drench::test
