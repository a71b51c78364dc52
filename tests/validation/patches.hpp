#pragma once
// Meshes of cloth as garments come, made by tests.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace drench::test {

/// Nodes (m) and triangles.
struct Patch {
  std::vector<Eigen::Vector3d> x;
  std::vector<std::array<int, 3>> t;
  std::string obj() const {
    std::string text;
    for (const auto& p : x) text += fmt::format("v {:.12f} {:.12f} {:.12f}\n", p[0], p[1], p[2]);
    for (const auto& c : t) text += fmt::format("f {} {} {}\n", c[0] + 1, c[1] + 1, c[2] + 1);
    return text;
  }
};

inline double noise(int n) { return std::sin(12.9898 * n + 1); }

/// L × W in x and z from the origin, its nodes up to `off` of a cell off their lattice and the diagonals at random:
/// many of its angles are obtuse.
inline Patch irregular_sheet(int along, int across, double length, double width, double off) {
  Patch p;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < along; ++i) {
      const int n = 2 * (i + along * j);
      const double di = i == 0 || i == along - 1 ? 0 : off * noise(n),
                   dj = j == 0 || j == across - 1 ? 0 : off * noise(n + 1);
      p.x.push_back({(i + di) * length / (along - 1), 0, (j + dj) * width / (across - 1)});
    }
  for (int j = 0; j + 1 < across; ++j)
    for (int i = 0; i + 1 < along; ++i) {
      const int a = i + along * j, b = a + 1, c = a + along, d = c + 1;
      if (noise(7 * a + 3) > 0) {
        p.t.push_back({a, c, d});
        p.t.push_back({a, d, b});
      } else {
        p.t.push_back({a, c, b});
        p.t.push_back({b, c, d});
      }
    }
  return p;
}

/// A sleeve: a tube about y whose radius falls from 0.08 to 0.05 m over 0.3 m, with an opening, no two triangles alike.
inline Patch sleeve() {
  constexpr int around = 30, along = 20;
  Patch p;
  std::vector<int> node;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const int n = 2 * (i + around * j);
      const bool boundary = j == 0 || j == along - 1;
      const double s = (j + (boundary ? 0 : 0.25 * noise(n))) / (along - 1),
                   angle = 2 * std::numbers::pi * (i + 0.25 * noise(n + 1)) / around;
      const double radius = 0.08 - 0.03 * s;
      const bool opening = j > 7 && j < 12 && i > 7 && i < 20;
      node.push_back(opening ? -1 : static_cast<int>(p.x.size()));
      if (!opening) p.x.push_back({radius * std::cos(angle), 0.3 * s, radius * std::sin(angle)});
    }
  const auto face = [&](int a, int b, int c) {
    if (a >= 0 && b >= 0 && c >= 0) p.t.push_back({a, b, c});
  };
  for (int j = 0; j + 1 < along; ++j)
    for (int i = 0; i < around; ++i) {
      const auto at = [&](int k, int l) { return node[static_cast<std::size_t>((j + l) * around + (i + k) % around)]; };
      face(at(0, 0), at(1, 0), at(0, 1));
      face(at(1, 0), at(1, 1), at(0, 1));
    }
  return p;
}

/// Every triangle in four; the old nodes keep their numbers.
inline Patch refined(const Patch& coarse) {
  Patch fine;
  fine.x = coarse.x;
  std::map<std::array<int, 2>, int> middle;
  const auto between = [&](int a, int b) {
    const auto [at, made] = middle.insert({{std::min(a, b), std::max(a, b)}, static_cast<int>(fine.x.size())});
    if (made) fine.x.push_back((coarse.x[static_cast<std::size_t>(a)] + coarse.x[static_cast<std::size_t>(b)]) / 2);
    return at->second;
  };
  for (const auto& [a, b, c] : coarse.t) {
    const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
    for (const std::array<int, 3>& t :
         {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
      fine.t.push_back(t);
  }
  return fine;
}

}  // namespace drench::test
