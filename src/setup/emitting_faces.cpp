#include "setup/emitting_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "base/eigen_vec.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_io.hpp"
#include "setup/point_grid.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// A small part of a triangle, around its centroid.
struct Facet {
  Index triangle;
  std::array<double, 3> weight;  // of the corners
  double part;                   // of the triangle's area
};

std::array<Vector3d, 3> corners(const std::vector<Vec3>& points, const std::array<Index, 3>& t) {
  const auto at = [&](Index i) { return to_eigen(points[static_cast<std::size_t>(i)]); };
  return {at(t[0]), at(t[1]), at(t[2])};
}

/// Twice the area, along the normal, m².
Vector3d area_vector(const std::array<Vector3d, 3>& x) { return (x[1] - x[0]).cross(x[2] - x[0]); }

Vector3d point_of(const std::array<Vector3d, 3>& x, const Facet& f) {
  return f.weight[0] * x[0] + f.weight[1] * x[1] + f.weight[2] * x[2];
}

/// k² congruent parts of each triangle, with areas of at most size².
std::vector<Facet> facets_of(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
                             double size) {
  std::vector<Facet> facets;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double area = 0.5 * area_vector(corners(points, triangles[t])).norm();
    const int k = std::max(1, static_cast<int>(std::ceil(std::sqrt(area) / size)));
    const auto add = [&](double a, double b) {
      facets.push_back({static_cast<Index>(t), {1 - (a + b) / k, a / k, b / k}, 1.0 / k / k});
    };
    for (int i = 0; i < k; ++i)
      for (int j = 0; i + j < k; ++j) {
        add(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < k) add(i + 2.0 / 3, j + 2.0 / 3);
      }
  }
  return facets;
}

/// m²: what each triangle emits for: its area, or that seen along the scene's direction.
std::vector<double> emitting_areas(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
                                   const MeshJetScene& scene) {
  const Vector3d direction = scene.direction ? to_eigen(*scene.direction).normalized() : Vector3d::Zero();
  std::vector<double> areas;
  for (const auto& t : triangles) {
    const Vector3d twice = area_vector(corners(points, t));
    areas.push_back(0.5 * (scene.direction ? std::max(0.0, twice.dot(direction)) : twice.norm()));
  }
  return areas;
}

/// Weights of a triangle's corners that give its point below x.
std::array<double, 3> weights_below(const std::array<Vector3d, 3>& corner, const Vector3d& x) {
  const Vector3d normal = area_vector(corner);
  std::array<double, 3> weights{};
  for (std::size_t c = 0; c < 3; ++c)
    weights[c] =
        normal.dot((corner[(c + 2) % 3] - corner[(c + 1) % 3]).cross(x - corner[(c + 1) % 3])) / normal.squaredNorm();
  return weights;
}

/// Parts of the surface around points that lie evenly on it.
struct Cells {
  std::vector<Facet> point;                     // in the middle of each
  std::vector<std::vector<std::size_t>> facet;  // of each
};

/// Makes a centroidal power diagram of the surface, whose cells emit alike (Lloyd 1982; Balzer, Schlömer and Deussen
/// 2009). Where they did not, liquid would be denser than at rest as it leaves, and burst.
class CellMaker {
 public:
  CellMaker(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles,
            const MeshJetScene& scene, const std::vector<Facet>& facets, double spacing)
      : d_(spacing), points_(points), triangles_(triangles), facets_(facets), cell_(facets.size(), 0) {
    const std::vector<double> areas = emitting_areas(points, triangles, scene);
    const Vector3d along = scene.direction ? to_eigen(*scene.direction).normalized() : Vector3d::Zero();
    for (const Facet& f : facets) {
      const auto x = corners(points, triangles[static_cast<std::size_t>(f.triangle)]);
      const Vector3d twice = area_vector(x), place = point_of(x, f);
      // Distances across the liquid's direction are what its particles have.
      constexpr double kept = 0.25;
      place_.push_back(place - (1 - kept) * place.dot(along) * along);
      area_.push_back(f.part * areas[static_cast<std::size_t>(f.triangle)]);
      normal_.push_back(twice.norm() > 0 ? Vector3d(twice.normalized()) : Vector3d::Zero());
    }
  }

  Cells make() {
    begin_far_apart();
    // After 100, particles leave with 1 % of compression in the mean. Large meshes have to do with fewer.
    const int rounds = std::clamp(static_cast<int>(1e6 / static_cast<double>(seeds_.size())), 20, 100);
    for (int round = 0; round < rounds; ++round) {
      center_seeds();
      divide_anew();
    }
    center_seeds();
    return cells();
  }

 private:
  struct Seed {
    Vector3d place, normal;  // m; unit
    double weight = 0;       // m²: facets belong to the seed with the least distance² − weight
  };

  /// The two sides of a thin sheet have cells of their own.
  bool looks_alike(std::size_t facet, const Seed& seed) const { return normal_[facet].dot(seed.normal) > 0; }

  /// Begins with facets none of which is closer than 0.8 spacings to another, about 1.1 per spacing².
  void begin_far_apart() {
    const double least = 0.8 * d_;
    PointGrid grid(least);
    const auto n = static_cast<std::int64_t>(place_.size()), stride = golden_stride(n);
    std::vector<std::size_t> left_over, silent;
    for (std::int64_t k = 0; k < n; ++k) {
      const auto f = static_cast<std::size_t>(k * stride % n);
      if (!(area_[f] > 0)) {  // it may emit in another file
        silent.push_back(f);
        continue;
      }
      if (nearest(grid, f, least)) {
        left_over.push_back(f);
        continue;
      }
      grid.add(to_vec3(place_[f]));
      cell_[f] = seeds_.size();
      seeds_.push_back({place_[f], normal_[f]});
    }
    for (const std::size_t f : left_over) cell_[f] = *nearest(grid, f, least);
    for (const std::size_t f : silent) {
      const auto away = [&](const Seed& seed) { return (place_[f] - seed.place).squaredNorm(); };
      cell_[f] =
          static_cast<std::size_t>(std::min_element(seeds_.begin(), seeds_.end(),
                                                    [&](const Seed& a, const Seed& b) { return away(a) < away(b); }) -
                                   seeds_.begin());
    }
  }

  /// The seed of those in the grid that is nearest to a facet, within a distance.
  std::optional<std::size_t> nearest(const PointGrid& grid, std::size_t f, double within) const {
    std::optional<std::size_t> found;
    double best = within * within;
    grid.for_box(to_vec3(place_[f].array() - within), to_vec3(place_[f].array() + within), [&](Index p) {
      const auto seed = static_cast<std::size_t>(p);
      const double away = (place_[f] - seeds_[seed].place).squaredNorm();
      if (!(away < best) || !looks_alike(f, seeds_[seed])) return;
      best = away;
      found = seed;
    });
    return found;
  }

  /// Moves the seeds to the middles of their cells, and makes the weights of cells that emit too much smaller.
  void center_seeds() {
    std::vector<double> area(seeds_.size(), 0.0);
    std::vector<Seed> sum(seeds_.size(), Seed{Vector3d::Zero(), Vector3d::Zero()});
    double all = 0;
    for (std::size_t f = 0; f < place_.size(); ++f) {
      area[cell_[f]] += area_[f];
      sum[cell_[f]].place += area_[f] * place_[f];
      sum[cell_[f]].normal += area_[f] * normal_[f];
      all += area_[f];
    }
    constexpr double gain = 0.3;
    for (std::size_t p = 0; p < seeds_.size(); ++p) {
      seeds_[p].weight += gain * (all / static_cast<double>(seeds_.size()) - area[p]);
      if (!(area[p] > 0)) continue;
      seeds_[p].place = sum[p].place / area[p];
      if (sum[p].normal.norm() > 0) seeds_[p].normal = sum[p].normal.normalized();
    }
  }

  /// Each facet goes to a seed around that which it has been with.
  void divide_anew() {
    const double reach = 2.5 * d_;
    PointGrid grid(reach);
    for (const Seed& seed : seeds_) grid.add(to_vec3(seed.place));
    std::vector<std::vector<std::size_t>> around(seeds_.size());
    for (std::size_t p = 0; p < seeds_.size(); ++p)
      grid.for_box(to_vec3(seeds_[p].place.array() - reach), to_vec3(seeds_[p].place.array() + reach), [&](Index q) {
        const auto other = static_cast<std::size_t>(q);
        if ((seeds_[p].place - seeds_[other].place).norm() < reach) around[p].push_back(other);
      });
    for (std::size_t f = 0; f < place_.size(); ++f) {
      double best = std::numeric_limits<double>::infinity();
      const std::size_t before = cell_[f];
      for (const std::size_t p : around[before]) {
        const double away = (place_[f] - seeds_[p].place).squaredNorm() - seeds_[p].weight;
        if (!(away < best) || !(p == before || looks_alike(f, seeds_[p]))) continue;
        best = away;
        cell_[f] = p;
      }
    }
  }

  /// Without those that have lost all that emits.
  Cells cells() const {
    std::vector<std::vector<std::size_t>> of_seed(seeds_.size());
    for (std::size_t f = 0; f < place_.size(); ++f) of_seed[cell_[f]].push_back(f);
    Cells cells;
    for (std::size_t p = 0; p < seeds_.size(); ++p) {
      const auto emits = [&](std::size_t f) { return area_[f] > 0; };
      const auto first = std::find_if(of_seed[p].begin(), of_seed[p].end(), emits);
      if (first == of_seed[p].end()) continue;
      std::size_t middle = *first;
      for (const std::size_t f : of_seed[p])
        if (emits(f) && (place_[f] - seeds_[p].place).squaredNorm() < (place_[middle] - seeds_[p].place).squaredNorm())
          middle = f;
      cells.point.push_back(middle_of(of_seed[p], facets_[middle].triangle));
      cells.facet.push_back(std::move(of_seed[p]));
    }
    return cells;
  }

  /// The middle of facets, on a triangle.
  Facet middle_of(const std::vector<std::size_t>& cell, Index triangle) const {
    Vector3d middle = Vector3d::Zero();
    double area = 0;
    for (const std::size_t f : cell) {
      middle +=
          area_[f] * point_of(corners(points_, triangles_[static_cast<std::size_t>(facets_[f].triangle)]), facets_[f]);
      area += area_[f];
    }
    return {triangle, weights_below(corners(points_, triangles_[static_cast<std::size_t>(triangle)]), middle / area),
            0};
  }

  double d_;
  const std::vector<Vec3>& points_;
  const std::vector<std::array<Index, 3>>& triangles_;
  const std::vector<Facet>& facets_;
  std::vector<Vector3d> place_, normal_;
  std::vector<double> area_;  // m²: what each emits for
  std::vector<Seed> seeds_;
  std::vector<std::size_t> cell_;  // of each facet
};

std::vector<std::vector<Vec3>> placed_files(const MeshSequenceReader& reader, const MeshJetScene& scene,
                                            const std::string& name) {
  std::vector<std::vector<Vec3>> placed;
  for (std::size_t k = 0; k < reader.size(); ++k) {
    const std::string label = reader.size() > 1 ? fmt::format("{} ({})", name, reader.label(k)) : name;
    SurfaceMesh mesh = reader.read(k);
    if (mesh.triangles != reader.first().triangles || mesh.points.size() != reader.first().points.size())
      throw SetupError(label +
                       ": its triangles differ from those of the first file; allowed: files that differ only in the "
                       "positions of their points");
    file_place(scene.placed)(mesh.points);
    check_points(mesh.points, label);
    placed.push_back(std::move(mesh.points));
  }
  return placed;
}

/// What a mesh emits for whose points move in straight lines from file to file: quadratic in time, or the root of a
/// polynomial, where faces change their shape or turn.
class MovingArea {
 public:
  MovingArea(const std::vector<std::vector<Vec3>>& files, const std::vector<std::array<Index, 3>>& triangles,
             const MeshJetScene& scene)
      : files_(files), triangles_(triangles), scene_(scene) {}

  Key<double> at_file(std::size_t file) const { return {static_cast<double>(file), sum_of(files_[file])}; }

  /// Adds keys after `from`, of a file or between two, up to `to`, halving until straight lines differ by `most`, m².
  void add_until(const Key<double>& to, const Key<double>& from, double most, std::vector<Key<double>>& keys,
                 int halved = 0) const {
    const Key<double> middle = between(0.5 * (from.time + to.time));
    const bool straight = std::abs(middle.value - 0.5 * (from.value + to.value)) <= most;
    if ((straight && halved > 0) || halved == 9) {
      keys.push_back(middle);
      keys.push_back(to);
      return;
    }
    add_until(middle, from, most, keys, halved + 1);
    add_until(to, middle, most, keys, halved + 1);
  }

 private:
  Key<double> between(double time) const {
    const auto file = static_cast<std::size_t>(time);
    std::vector<Vec3> points = files_[file];
    for (std::size_t p = 0; p < points.size(); ++p)
      points[p] = to_vec3(to_eigen(points[p]) +
                          (time - static_cast<double>(file)) * (to_eigen(files_[file + 1][p]) - to_eigen(points[p])));
    return {time, sum_of(points)};
  }
  double sum_of(const std::vector<Vec3>& points) const {
    const std::vector<double> areas = emitting_areas(points, triangles_, scene_);
    return std::accumulate(areas.begin(), areas.end(), 0.0);
  }

  const std::vector<std::vector<Vec3>>& files_;
  const std::vector<std::array<Index, 3>>& triangles_;
  const MeshJetScene& scene_;
};

}  // namespace

std::int64_t golden_stride(std::int64_t n) {
  const auto ideal = static_cast<std::int64_t>(std::llround(static_cast<double>(n) / std::numbers::phi));
  for (std::int64_t away = 0; away < n; ++away)
    for (const std::int64_t stride : {ideal - away, ideal + away})
      if (stride > 0 && stride < n && std::gcd(stride, n) == 1) return stride;
  return 1;
}

EmittingFaces emitting_faces(const MeshJetScene& scene, const std::string& scene_path, double spacing,
                             const std::string& name) {
  const MeshSequenceReader reader(scene.sequence, scene.placed.file, scene_path);
  const std::vector<std::array<Index, 3>>& triangles = reader.first().triangles;
  const std::vector<std::vector<Vec3>> placed = placed_files(reader, scene, name);

  // The points lie evenly on the file in which the most emits.
  EmittingFaces faces;
  faces.time = reader.times();
  Eigen::AlignedBox3d box;
  for (const Vec3& x : placed.front()) box.extend(to_eigen(x));
  faces.center = to_vec3(box.center());
  const MovingArea area(placed, triangles, scene);
  std::vector<Key<double>> of_files;
  for (std::size_t k = 0; k < placed.size(); ++k) of_files.push_back(area.at_file(k));
  const auto largest = static_cast<std::size_t>(
      std::max_element(of_files.begin(), of_files.end(),
                       [](const Key<double>& a, const Key<double>& b) { return a.value < b.value; }) -
      of_files.begin());
  const double most = of_files[largest].value, least = 0.5 * spacing * spacing;
  if (scene.direction && !(most > 0))
    throw SetupError(name +
                     ": none of its faces looks along `direction`; allowed: the opposite direction, or none for flow "
                     "along the normals");
  if (!(most >= least))
    throw SetupError(fmt::format(
        "{}: its faces have {:.3g} m²{}, less than half a particle's {:.3g} m²; allowed: a larger mesh or a smaller "
        "spacing",
        name, most, scene.direction ? " that look along `direction`" : "", 2 * least));
  if (const double count = most / (spacing * spacing); count > max_face_points)
    throw SetupError(
        fmt::format("{}: its mouth needs {:.3g} particles at spacing {} m; allowed: at most {:.0e}, so a smaller mesh "
                    "or a larger spacing",
                    name, count, spacing, max_face_points));
  faces.area.push_back(of_files.front());
  for (std::size_t k = 1; k < placed.size(); ++k) area.add_until(of_files[k], of_files[k - 1], 1e-5 * most, faces.area);
  for (Key<double>& key : faces.area) {
    const auto file = std::min(static_cast<std::size_t>(key.time), placed.size() - 1),
               next = std::min(file + 1, placed.size() - 1);
    key.time = faces.time[file] + (key.time - static_cast<double>(file)) * (faces.time[next] - faces.time[file]);
  }
  const std::vector<Facet> facets = facets_of(placed[largest], triangles, spacing / 5);
  const Cells cells = CellMaker(placed[largest], triangles, scene, facets, spacing).make();
  const auto emitted_by = [&](std::size_t file) {
    const std::vector<double> areas = emitting_areas(placed[file], triangles, scene);
    std::vector<double> of_cell;
    for (const std::vector<std::size_t>& cell : cells.facet) {
      double sum = 0;
      for (const std::size_t f : cell) sum += facets[f].part * areas[static_cast<std::size_t>(facets[f].triangle)];
      of_cell.push_back(sum);
    }
    return of_cell;
  };
  const std::vector<double> at_most = emitted_by(largest);

  for (std::size_t k = 0; k < placed.size(); ++k) {
    std::vector<Vec3> points, normals;
    std::vector<double> flow;
    const std::vector<double> emitted = emitted_by(k);
    double sum = 0;
    for (std::size_t p = 0; p < cells.point.size(); ++p) {
      const Facet& middle = cells.point[p];
      const auto x = corners(placed[k], triangles[static_cast<std::size_t>(middle.triangle)]);
      points.push_back(to_vec3(point_of(x, middle)));
      const Vector3d normal = area_vector(x);
      if (normal.norm() > 0)
        normals.push_back(to_vec3(normal.normalized()));
      else
        normals.push_back(k > 0 ? faces.directions[k - 1][p] : Vec3{0, 1, 0});  // a face without area emits nothing
      flow.push_back(sum += emitted[p] / at_most[p]);
      if (k > 0)
        faces.fastest = std::max(faces.fastest, (to_eigen(points[p]) - to_eigen(faces.points[k - 1][p])).norm() /
                                                    (faces.time[k] - faces.time[k - 1]));
    }
    faces.points.push_back(std::move(points));
    faces.directions.push_back(std::move(normals));
    faces.flow.push_back(std::move(flow));
  }
  if (scene.direction)
    for (std::vector<Vec3>& directions : faces.directions)
      directions.assign(directions.size(), to_vec3(to_eigen(*scene.direction).normalized()));
  if (placed.size() == 1) faces.flow.clear();
  return faces;
}

}  // namespace drench
