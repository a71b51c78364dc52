#include "setup/distance_field.hpp"

#include <vtkCellArray.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

constexpr Index coarse = 4;  // lattice steps between points that are always exact

struct Lattice {
  const std::array<Index, 3>& points;
  std::size_t index(Index i, Index j, Index k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(points[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(points[0]) +
           static_cast<std::size_t>(i);
  }
};

/// The mesh with all triangles turned outwards.
vtkSmartPointer<vtkPolyData> oriented(const Body& body) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& x : body.mesh_points) points->InsertNextPoint(x.data());
  vtkNew<vtkCellArray> cells;
  for (const auto& t : body.mesh_triangles) cells->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(cells);
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(surface);
  normals->SplittingOff();
  normals->ConsistencyOn();
  normals->AutoOrientNormalsOn();
  normals->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  normals->Update();
  return normals->GetOutput();
}

}  // namespace

DistanceField lay_field(const Body& body, double spacing, double margin) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : body.mesh_points) bounds.extend(to_eigen(x));
  return lay_field(to_vec3(bounds.min()), to_vec3(bounds.max()), spacing, margin);
}

DistanceField lay_field(const Vec3& min, const Vec3& max, double spacing, double margin) {
  const Eigen::AlignedBox3d bounds(to_eigen(min), to_eigen(max));
  DistanceField field;
  field.spacing = 0.5 * spacing;
  for (int a = 0; a < 3; ++a) {
    // Whole coarse cells, at least one fine step beyond the margin.
    const double length = bounds.sizes()[a] + 2 * (margin + field.spacing);
    const double cells = std::ceil(length / (coarse * field.spacing));
    field.points[static_cast<std::size_t>(a)] = coarse * static_cast<Index>(std::min(cells, 1e6)) + 1;
    field.origin[static_cast<std::size_t>(a)] = bounds.center()[a] - 0.5 * coarse * cells * field.spacing;
  }
  return field;
}

void fill_field(const Body& body, DistanceField& field) {
  const auto mesh = oriented(body);
  vtkNew<vtkImplicitPolyDataDistance> distance;
  distance->SetInput(mesh);
  const Lattice at{field.points};
  const auto [nx, ny, nz] = field.points;
  field.value.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz), 0.0);
  const auto exact = [&](Index i, Index j, Index k) {
    double x[3] = {field.origin[0] + i * field.spacing, field.origin[1] + j * field.spacing,
                   field.origin[2] + k * field.spacing};
    return distance->EvaluateFunction(x);
  };
  for (Index k = 0; k < nz; k += coarse)
    for (Index j = 0; j < ny; j += coarse)
      for (Index i = 0; i < nx; i += coarse) field.value[at.index(i, j, k)] = exact(i, j, k);
  // A distance changes by no more than the way: cells whose corners are all farther than their diagonal do not meet the
  // surface. One more step for the gradient.
  const double near = (std::sqrt(3.0) * coarse + 1) * field.spacing;
  for (Index k = 0; k < nz; ++k) {
    for (Index j = 0; j < ny; ++j) {
      for (Index i = 0; i < nx; ++i) {
        if (i % coarse == 0 && j % coarse == 0 && k % coarse == 0) continue;
        const Index ci = std::min(i / coarse * coarse, nx - 1 - coarse),
                    cj = std::min(j / coarse * coarse, ny - 1 - coarse),
                    ck = std::min(k / coarse * coarse, nz - 1 - coarse);
        const double u = static_cast<double>(i - ci) / coarse, v = static_cast<double>(j - cj) / coarse,
                     w = static_cast<double>(k - ck) / coarse;
        double nearest = 1e300, mixed = 0;
        for (int c = 0; c < 8; ++c) {
          const double value =
              field.value[at.index(ci + (c & 1) * coarse, cj + (c >> 1 & 1) * coarse, ck + (c >> 2) * coarse)];
          nearest = std::min(nearest, std::abs(value));
          mixed += value * (c & 1 ? u : 1 - u) * (c & 2 ? v : 1 - v) * (c & 4 ? w : 1 - w);
        }
        field.value[at.index(i, j, k)] = nearest > near ? mixed : exact(i, j, k);
      }
    }
  }
}

std::function<double(const Vec3&)> exact_distance(const Body& body) {
  const auto distance = vtkSmartPointer<vtkImplicitPolyDataDistance>::New();
  distance->SetInput(oriented(body));
  return [distance](const Vec3& x) {
    double at[3] = {x[0], x[1], x[2]};
    return distance->EvaluateFunction(at);
  };
}

double field_distance(const DistanceField& field, const Vec3& x, Vec3& normal) {
  constexpr double far_away = 1e30;
  normal = {0, 0, 0};
  if (field.empty()) return far_away;
  std::array<Index, 3> cell{};
  std::array<double, 3> part{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double where = (x[a] - field.origin[a]) / field.spacing;
    if (!(where >= 0 && where <= field.points[a] - 1)) return far_away;
    cell[a] = std::min(static_cast<Index>(where), field.points[a] - 2);
    part[a] = where - cell[a];
  }
  const Lattice at{field.points};
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const int on[3] = {c & 1, c >> 1 & 1, c >> 2};
    const double corner = field.value[at.index(cell[0] + on[0], cell[1] + on[1], cell[2] + on[2])];
    Eigen::Vector3d weight;
    for (std::size_t a = 0; a < 3; ++a) weight[static_cast<int>(a)] = on[a] ? part[a] : 1 - part[a];
    value += corner * weight.prod();
    gradient +=
        corner * Eigen::Vector3d((on[0] ? 1 : -1) * weight[1] * weight[2], (on[1] ? 1 : -1) * weight[0] * weight[2],
                                 (on[2] ? 1 : -1) * weight[0] * weight[1]);
  }
  const double length = gradient.norm();
  normal = length > 0 ? to_vec3(gradient / length) : Vec3{0, 1, 0};
  return value;
}

}  // namespace drench
