#pragma once
// A hashed cell map of points, for set-up: thinning, overlaps and Akinci volumes. Not the solver's neighbour search.

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/types.hpp"
#include "scene/scene.hpp"

namespace drench {

class PointGrid {
 public:
  using Cell = std::array<std::int64_t, 3>;

  /// `edge` (m) is the largest distance that near() can look over.
  explicit PointGrid(double edge) : edge_(edge) {}

  void add(const Vec3& x) {
    cells_[cell_of(x)].push_back(static_cast<Index>(points_.size()));
    points_.push_back(x);
  }

  /// Is a point of the grid closer than `distance` ≤ edge?
  bool any_within(const Vec3& x, double distance) const;

  /// Calls f(index) for the points of all cells that overlap the box [min, max].
  template <class F>
  void for_box(const Vec3& min, const Vec3& max, F&& f) const {
    const Cell lo = cell_of(min), hi = cell_of(max);
    for (auto i = lo[0]; i <= hi[0]; ++i) {
      for (auto j = lo[1]; j <= hi[1]; ++j) {
        for (auto k = lo[2]; k <= hi[2]; ++k) {
          const auto found = cells_.find({i, j, k});
          if (found == cells_.end()) continue;
          for (const Index p : found->second) f(p);
        }
      }
    }
  }

  Cell cell_of(const Vec3& x) const {
    Cell c;
    for (int a = 0; a < 3; ++a) c[a] = static_cast<std::int64_t>(std::floor(x[a] / edge_));
    return c;
  }
  const std::vector<Vec3>& points() const { return points_; }

 private:
  friend std::vector<double> akinci_volumes(const std::vector<Vec3>& points, double support, KernelKind kernel);
  struct Hash {
    std::size_t operator()(const Cell& c) const;
  };
  double edge_;
  std::vector<Vec3> points_;
  std::unordered_map<Cell, std::vector<Index>, Hash> cells_;
};

/// V_b = 1 / Σ_k W_bk over `points` closer than the support radius h, itself included; m³ (Akinci et al. 2012).
std::vector<double> akinci_volumes(const std::vector<Vec3>& points, double support, KernelKind kernel);

/// d³ Σ W over a plane square lattice of spacing d: what an Akinci volume on it is multiplied with, so that the plane
/// counts for one layer of liquid (src/stages/density.hpp).
double layer_share(double spacing, double support, KernelKind kernel);

}  // namespace drench
