// Polygons of any kind divided into triangles.

#include "setup/triangulation.hpp"

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "base/eigen_vec.hpp"

namespace drench::testing {
namespace {

double signed_area(const std::vector<Vec3>& x, const std::array<int, 3>& t) {
  const auto at = [&](std::size_t k) { return to_eigen(x[static_cast<std::size_t>(t[k])]); };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0))[2];
}

double polygon_area(const std::vector<Vec3>& x) {
  double area = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 &a = x[i], &b = x[(i + 1) % x.size()];
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return area;
}

/// The triangles by VTK's filter, each and all in rising order.
std::vector<std::array<int, 3>> sorted(std::vector<std::array<int, 3>> triangles) {
  for (auto& t : triangles) std::sort(t.begin(), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}
std::vector<std::array<int, 3>> by_vtk(const std::vector<Vec3>& x) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> faces;
  faces->InsertNextCell(static_cast<int>(x.size()));
  for (std::size_t i = 0; i < x.size(); ++i) {
    points->InsertNextPoint(x[i].data());
    faces->InsertCellPoint(static_cast<vtkIdType>(i));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(faces);
  vtkNew<vtkTriangleFilter> filter;
  filter->SetInputData(data);
  filter->Update();
  std::vector<std::array<int, 3>> triangles;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < filter->GetOutput()->GetNumberOfPolys(); ++c) {
    filter->GetOutput()->GetPolys()->GetCellAtId(c, ids);
    triangles.push_back(
        {static_cast<int>(ids->GetId(0)), static_cast<int>(ids->GetId(1)), static_cast<int>(ids->GetId(2))});
  }
  return triangles;
}

TEST(Triangulation, ConvexPolygonsGiveTheTrianglesOfVtk) {
  std::mt19937 random(11);
  int compared = 0;
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int n = 4; n < 9; ++n)
    for (int trial = 0; trial < 300; ++trial) {
      std::vector<Vec3> x;
      for (int i = 0; i < n; ++i) {
        const double turn = 2 * std::numbers::pi * i / n;
        x.push_back(
            {std::cos(turn) + uniform(random) / n, std::sin(turn) + uniform(random) / n, 0.2 * uniform(random)});
      }
      const auto expected = by_vtk(x);
      if (static_cast<int>(expected.size()) != n - 2) continue;  // VTK gave up
      EXPECT_EQ(sorted(triangulate(x)), sorted(expected));
      ++compared;
    }
  EXPECT_GT(compared, 1000);
}

TEST(Triangulation, StarsAreCoveredOnceAndTurnedAsTheyAre) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 500; ++trial) {
    const int n = 4 + static_cast<int>(30 * uniform(random));
    std::vector<Vec3> x;
    for (int i = 0; i < n; ++i) {
      const double turn = (trial % 2 ? 2 : -2) * std::numbers::pi * i / n, r = 0.1 + uniform(random);
      x.push_back({r * std::cos(turn), r * std::sin(turn), 0});
    }
    const auto triangles = triangulate(x);
    ASSERT_EQ(static_cast<int>(triangles.size()), n - 2);
    double sum = 0, unsigned_sum = 0;
    for (const auto& t : triangles) {
      sum += signed_area(x, t);
      unsigned_sum += std::abs(signed_area(x, t));
    }
    EXPECT_NEAR(sum, polygon_area(x), 1e-12) << trial;
    EXPECT_NEAR(unsigned_sum, std::abs(sum), 1e-12) << "one is turned over, trial " << trial;
  }
}

TEST(Triangulation, EveryPolygonGivesTwoTrianglesLessThanItHasCorners) {
  const std::vector<std::vector<Vec3>> polygons = {
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},                                         // crosses itself: no area
      {{0, 0, 0}, {1, 0, 0}, {0.45, 1, 0}, {0.55, 1, 0}},                                   // a little
      {{1, 0, 0}, {-0.8, 0.6, 0}, {0.3, -0.95, 0}, {0.3, 0.95, 0}, {-0.8, -0.6, 0}},        // a pentagram
      {{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 1, 0}, {0, 1, 0}, {0, 0.5, 0}},  // corners in lines
      {{0, 0, 0}, {1, 0, 1}, {1, 1, -1}, {0, 1, 1}, {-1, 0.5, -1}},                         // not plane
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 0}, {2, -1, 0}},                             // to and fro
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}};                                        // a line
  for (const auto& x : polygons) {
    const auto triangles = triangulate(x);
    EXPECT_EQ(triangles.size(), x.size() - 2);
    std::vector<int> seen(x.size(), 0);
    for (const auto& t : triangles)
      for (const int k : t) seen[static_cast<std::size_t>(k)] = 1;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(x.size()));
  }
  // Corners in a line make no triangle of their own.
  for (const auto& t : triangulate(polygons[3])) EXPECT_GT(signed_area(polygons[3], t), 0.01);
}

}  // namespace
}  // namespace drench::testing
