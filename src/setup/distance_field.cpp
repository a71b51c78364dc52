#include "setup/distance_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "setup/surface_distance.hpp"

namespace drench {
namespace {

constexpr Index coarse = 4;  // lattice steps between points that are always exact

using Triangles = std::vector<std::array<Index, 3>>;

/// Without the hidden ones: where parts of a mesh overlap or touch, the depth below the surface of them all counts.
Triangles outer_triangles(const Body& body, const WindingNumber& winding, int threads) {
  const std::vector<std::uint8_t> hidden = hidden_triangles(body, winding, threads);
  Triangles outer;
  for (std::size_t t = 0; t < hidden.size(); ++t)
    if (hidden[t] == 0) outer.push_back(body.mesh_triangles[t]);
  return outer.empty() ? body.mesh_triangles : outer;
}

/// Distances of the lattice's points to a body's surface.
class FieldFilling {
 public:
  FieldFilling(const Body& body, DistanceField& field, int threads)
      : field_(field),
        winding_(body.mesh_points, body.mesh_triangles),
        tree_(body.mesh_points, outer_triangles(body, winding_, threads)) {}

  /// Rows of points that are always exact: along x with j, k multiples of `coarse`.
  void fill_coarse_row(Index j, Index k) {
    const std::vector<std::int8_t> inside = inside_of_row(j, k);
    Index near = 0;
    for (Index i = 0; i < field_.points[0]; i += coarse)
      field_.value[field_.index(i, j, k)] = exact(i, j, k, inside, near);
  }

  /// The other points from layer `ck` on, as many layers as a coarse step has, and the last layer with those before it.
  void fill_layers(Index ck) {
    const auto [nx, ny, nz] = field_.points;
    std::vector<std::vector<std::int8_t>> inside;  // of the rows of these layers, by k and j
    for (Index k = ck; k < end_of(ck, nz); ++k)
      for (Index j = 0; j < ny; ++j) inside.push_back(inside_of_row(j, k));
    Near near;
    for (Index cj = 0; cj + 1 < ny; cj += coarse)
      for (Index ci = 0; ci + 1 < nx; ci += coarse) fill_cell(ci, cj, ck, inside, near);
  }

 private:
  /// Triangles near a cell and near its eighths.
  struct Near {
    TriangleTree::Candidates of_cell;
    std::array<TriangleTree::Candidates, 8> of_part;
    Index triangle = 0;
  };

  Vec3 place(Index i, Index j, Index k) const {
    return {field_.origin[0] + i * field_.spacing, field_.origin[1] + j * field_.spacing,
            field_.origin[2] + k * field_.spacing};
  }
  /// Of each point of a row: 1 inside.
  std::vector<std::int8_t> inside_of_row(Index j, Index k) const {
    std::vector<WindingNumber::Crossing> crossings;
    const Vec3 first = place(0, j, k);
    winding_.crossings(first[1], first[2], crossings);
    std::vector<std::int8_t> inside(static_cast<std::size_t>(field_.points[0]), 0);
    std::size_t next = 0;
    int winding = 0;
    for (Index i = field_.points[0] - 1; i >= 0; --i) {
      for (const double x = place(i, j, k)[0]; next < crossings.size() && crossings[next].x > x; ++next)
        winding += crossings[next].change;
      inside[static_cast<std::size_t>(i)] = winding >= 1;
    }
    return inside;
  }
  double exact(Index i, Index j, Index k, const std::vector<std::int8_t>& inside, Index& near) const {
    const double distance = std::sqrt(tree_.squared_distance(to_eigen(place(i, j, k)), near));
    return inside[static_cast<std::size_t>(i)] ? -distance : distance;
  }
  /// One past the last point of a coarse cell's own; the last cell has its far side too.
  static Index end_of(Index first, Index points) { return first + coarse + 1 == points ? points : first + coarse; }

  /// A distance changes by no more than the way: cells whose corners are all farther than their diagonal do not meet
  /// the surface. One more step for the gradient.
  void fill_cell(Index ci, Index cj, Index ck, const std::vector<std::vector<std::int8_t>>& inside, Near& near) {
    std::array<double, 8> corner{};
    double nearest = 1e300;
    for (int c = 0; c < 8; ++c) {
      corner[static_cast<std::size_t>(c)] =
          field_.value[field_.index(ci + (c & 1) * coarse, cj + (c >> 1 & 1) * coarse, ck + (c >> 2) * coarse)];
      nearest = std::min(nearest, std::abs(corner[static_cast<std::size_t>(c)]));
    }
    if (nearest <= (std::sqrt(3.0) * coarse + 1) * field_.spacing) return fill_near_cell(ci, cj, ck, inside, near);
    for_own_points(ci, cj, ck, [&](Index i, Index j, Index k) {
      const double u = static_cast<double>(i - ci) / coarse, v = static_cast<double>(j - cj) / coarse,
                   w = static_cast<double>(k - ck) / coarse;
      double& value = field_.value[field_.index(i, j, k)];
      value = 0;
      for (int c = 0; c < 8; ++c)
        value += corner[static_cast<std::size_t>(c)] * (c & 1 ? u : 1 - u) * (c & 2 ? v : 1 - v) * (c & 4 ? w : 1 - w);
    });
  }
  /// Calls f(i, j, k) for the cell's own points that are not exact yet.
  template <class F>
  void for_own_points(Index ci, Index cj, Index ck, const F& f) const {
    for (Index k = ck; k < end_of(ck, field_.points[2]); ++k)
      for (Index j = cj; j < end_of(cj, field_.points[1]); ++j)
        for (Index i = ci; i < end_of(ci, field_.points[0]); ++i)
          if (i % coarse != 0 || j % coarse != 0 || k % coarse != 0) f(i, j, k);
  }
  /// All points of a box have their nearest triangle no farther from it than its middle has, and half its diagonal.
  void fill_near_cell(Index ci, Index cj, Index ck, const std::vector<std::vector<std::int8_t>>& inside,
                      Near& near) const {
    constexpr double rounding = 1 + 1e-6;
    constexpr Index half = coarse / 2;
    const auto box_of = [&](Index i, Index j, Index k, Index steps) {
      return Eigen::AlignedBox3d(to_eigen(place(i, j, k)), to_eigen(place(i + steps, j + steps, k + steps)));
    };
    const Eigen::AlignedBox3d cell = box_of(ci, cj, ck, coarse);
    const double in_middle = std::sqrt(tree_.squared_distance(cell.center(), near.triangle));
    tree_.find_candidates(cell, (in_middle + 0.5 * cell.diagonal().norm()) * rounding, near.of_cell);
    for (std::size_t c = 0; c < near.of_part.size(); ++c) {
      const auto part = static_cast<Index>(c);
      const Eigen::AlignedBox3d box =
          box_of(ci + (part & 1) * half, cj + (part >> 1 & 1) * half, ck + (part >> 2) * half, half);
      const double distance = std::sqrt(tree_.squared_distance(box.center(), near.of_cell, near.triangle));
      tree_.find_candidates(box, (distance + 0.5 * box.diagonal().norm()) * rounding, near.of_cell, near.of_part[c]);
    }
    for_own_points(ci, cj, ck, [&](Index i, Index j, Index k) {
      const std::size_t part = (i - ci >= half ? 1 : 0) + (j - cj >= half ? 2 : 0) + (k - ck >= half ? 4 : 0);
      const double distance =
          std::sqrt(tree_.squared_distance(to_eigen(place(i, j, k)), near.of_part[part], near.triangle));
      const bool is_inside =
          inside[static_cast<std::size_t>((k - ck) * field_.points[1] + j)][static_cast<std::size_t>(i)] != 0;
      field_.value[field_.index(i, j, k)] = is_inside ? -distance : distance;
    });
  }

  DistanceField& field_;
  WindingNumber winding_;
  TriangleTree tree_;
};

/// Calls f(i) for 0 … count − 1, each once; a thread takes the next one when it is done with its last.
template <class F>
void share_out(Index count, int threads, const F& f) {
  std::atomic<Index> next{0};
  for_ranges(static_cast<std::size_t>(std::max(1, threads)), threads, [&](std::size_t) {
    for (Index i = next++; i < count; i = next++) f(i);
  });
}

}  // namespace

std::vector<std::uint8_t> hidden_triangles(const Body& body, const WindingNumber& winding, int threads) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : body.mesh_points) bounds.extend(to_eigen(x));
  const double before = 1e-7 * bounds.sizes().maxCoeff();  // m: how far in front of a triangle to look
  constexpr double low = 0.05, high = 0.9;
  constexpr double looked_at[4][3] = {
      {1.0 / 3, 1.0 / 3, 1.0 / 3}, {high, low, low}, {low, high, low}, {low, low, high}};
  std::vector<std::uint8_t> hidden(body.mesh_triangles.size());
  for_ranges(hidden.size(), threads, [&](std::size_t k) {
    const auto& t = body.mesh_triangles[k];
    const auto point = [&](std::size_t c) { return to_eigen(body.mesh_points[static_cast<std::size_t>(t[c])]); };
    const Eigen::Vector3d front = before * (point(1) - point(0)).cross(point(2) - point(0)).normalized();
    bool within = true;
    for (const auto& w : looked_at)
      within = within && winding.around(to_vec3(w[0] * point(0) + w[1] * point(1) + w[2] * point(2) + front)) >= 1;
    hidden[k] = within ? 1 : 0;
  });
  return hidden;
}

DistanceField lay_field(const Body& body, double spacing, double margin) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : body.mesh_points) bounds.extend(to_eigen(x));
  return lay_field(to_vec3(bounds.min()), to_vec3(bounds.max()), spacing, margin);
}

DistanceField lay_field(const Vec3& min, const Vec3& max, double spacing, double margin) {
  const Eigen::AlignedBox3d bounds(to_eigen(min), to_eigen(max));
  // Whole coarse cells, at least one fine step beyond the margin.
  const auto cells_at = [&](double step) -> Eigen::Vector3d {
    const Eigen::Vector3d length = bounds.sizes() + Eigen::Vector3d::Constant(2 * (margin + step));
    return (length / (coarse * step)).array().ceil();
  };
  const auto points_at = [&](double step) { return (coarse * cells_at(step).array() + 1).prod(); };
  DistanceField field;
  field.spacing = 0.5 * spacing;
  for (double points = points_at(field.spacing); points > most_field_points; points = points_at(field.spacing))
    field.spacing *= 1.01 * std::cbrt(points / most_field_points);
  const Eigen::Vector3d cells = cells_at(field.spacing);
  for (int a = 0; a < 3; ++a) {
    field.points[static_cast<std::size_t>(a)] = coarse * static_cast<Index>(cells[a]) + 1;
    field.origin[static_cast<std::size_t>(a)] = bounds.center()[a] - 0.5 * coarse * cells[a] * field.spacing;
  }
  return field;
}

std::string coarse_field(const DistanceField& field, double spacing) {
  if (field.spacing < 0.505 * spacing) return "";
  const double longest = field.spacing * *std::max_element(field.points.begin(), field.points.end());
  return fmt::format(
      "its lattice of distances, {:.2g} m long, is limited to steps of {:.2g} m instead of {:.2g} m, which rounds "
      "finer details; cut the mesh to the part that cloth and liquid reach, or use a larger spacing",
      longest, field.spacing, 0.5 * spacing);
}

void fill_field(const Body& body, DistanceField& field, int threads) {
  const auto [nx, ny, nz] = field.points;
  field.value.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz), 0.0);
  FieldFilling filling(body, field, threads);
  const Index coarse_rows = (ny - 1) / coarse + 1;
  share_out((nz - 1) / coarse + 1, threads, [&, rows = coarse_rows](Index k) {
    for (Index j = 0; j < rows; ++j) filling.fill_coarse_row(coarse * j, coarse * k);
  });
  share_out((nz - 1) / coarse, threads, [&](Index k) { filling.fill_layers(coarse * k); });
}

std::function<double(const Vec3&)> exact_distance(const Body& body) {
  const auto winding = std::make_shared<WindingNumber>(body.mesh_points, body.mesh_triangles);
  const auto tree = std::make_shared<TriangleTree>(body.mesh_points, outer_triangles(body, *winding, 1));
  return [winding, tree](const Vec3& x) {
    Index near = 0;
    const double distance = std::sqrt(tree->squared_distance(to_eigen(x), near));
    return winding->around(x) >= 1 ? -distance : distance;
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
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const int on[3] = {c & 1, c >> 1 & 1, c >> 2};
    const double corner = field.value[field.index(cell[0] + on[0], cell[1] + on[1], cell[2] + on[2])];
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
