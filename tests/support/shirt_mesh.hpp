#pragma once
// The tutorial's shirt and dress form (docs/tutorial/make_shirt.py), as coarse as a test wants them.

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "ball_mesh.hpp"

namespace drench::test {

/// A sleeveless shirt of two sheets of rows × 4/5 rows squares, sewn at the sides and on the shoulders; hem at y = 0,
/// m.
inline TestMesh shirt_mesh(int rows) {
  using std::numbers::pi;
  const int columns = rows * 4 / 5, armpit = rows * 3 / 5;
  const auto point = [&](int side, int row, int column) {
    const double across = 1 - 2.0 * column / columns, sine = std::sin(pi * column / columns);
    const double neckline = (side > 0 ? 0.16 : 0.06) * std::pow(std::max(0.0, 1 - std::abs(across) / 0.6), 1.2);
    const double y = (0.6 - neckline) * row / rows, height = y / 0.6;
    const double up = std::max(0.0, (height - double(armpit) / rows) / (1 - double(armpit) / rows));
    const double width = 0.25 - 0.03 * std::min(1.0, height * rows / armpit) - 0.065 * std::pow(up, 0.6);
    const double opening = sine + (0.6 - sine) * std::pow(up, 0.7);
    return Eigen::Vector3d(width * ((1 - height) * std::cos(pi * column / columns) + height * across), y,
                           side * 0.11 * std::sqrt(1 - std::min(1.0, up) * std::min(1.0, up)) * opening);
  };
  const auto sewn = [&](int row, int column) {
    return ((column == 0 || column == columns) && row <= armpit) ||
           (row == rows && std::abs(1 - 2.0 * column / columns) >= 0.6);
  };
  TestMesh mesh;
  std::map<std::tuple<int, int, int>, int> numbers;
  const auto number = [&](int side, int row, int column) {
    const auto [at, fresh] = numbers.try_emplace({sewn(row, column) ? 0 : side, row, column}, int(mesh.points.size()));
    if (fresh) mesh.points.push_back(point(side, row, column));
    return at->second;
  };
  for (const int side : {1, -1})
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const int a = number(side, row, column), b = number(side, row, column + 1);
        const int c = number(side, row + 1, column + 1), d = number(side, row + 1, column);
        std::array<int, 3> one{a, b, (row + column) % 2 ? c : d}, two{(row + column) % 2 ? a : b, c, d};
        if (side > 0) {  // normals point outwards
          std::swap(one[0], one[2]);
          std::swap(two[0], two[2]);
        }
        mesh.triangles.push_back(one);
        mesh.triangles.push_back(two);
      }
  return mesh;
}

/// The closed form that wears it, of ellipses with `around` points.
inline TestMesh form_mesh(int around) {
  constexpr double ellipse[][3] = {{-0.08, 0.150, 0.070}, {0.00, 0.170, 0.085}, {0.12, 0.165, 0.080},
                                   {0.24, 0.160, 0.076},  {0.34, 0.175, 0.080}, {0.42, 0.175, 0.072},
                                   {0.48, 0.165, 0.058},  {0.52, 0.148, 0.047}, {0.55, 0.115, 0.042},
                                   {0.57, 0.075, 0.041},  {0.60, 0.052, 0.042}, {0.68, 0.048, 0.044}};
  TestMesh mesh;
  for (const auto& [y, width, depth] : ellipse)
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      mesh.points.emplace_back(width * std::cos(angle), y, depth * std::sin(angle));
    }
  const int last = 11 * around, bottom = 12 * around, top = bottom + 1;
  mesh.points.emplace_back(0, ellipse[0][0], 0);
  mesh.points.emplace_back(0, ellipse[11][0], 0);
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around;
    for (int row = 0; row < last; row += around) {
      mesh.triangles.push_back({row + k, row + around + next, row + next});
      mesh.triangles.push_back({row + k, row + around + k, row + around + next});
    }
    mesh.triangles.push_back({bottom, k, next});
    mesh.triangles.push_back({top, last + next, last + k});
  }
  return mesh;
}

}  // namespace drench::test
