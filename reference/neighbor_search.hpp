#pragma once
// Neighbour search of the reference, shared by the stages neighbors and porous_neighbors.

#include <array>

#include "common.hpp"

namespace drench::reference {

/// Points sorted by cell (edge h, counted from the smallest coordinates; z, then y, then x) and by `key` within a cell.
class SortedCells {
 public:
  /// `key` holds one number a point, or is empty: then the index is the key. Points that are not finite are nobody's
  /// neighbours and are left out.
  SortedCells(const Vectors& points, double support, const std::vector<std::int64_t>& key = {});
  /// All points closer than h to each row; with `same_set` a row does not list itself.
  NeighborLists around(const Vectors& rows, bool same_set) const;

 private:
  struct Entry {
    std::array<std::int64_t, 3> cell;  // z, y, x
    std::int64_t key;
    Index point;
  };
  std::array<std::int64_t, 3> cell_of(const Eigen::Vector3d& x) const;
  Vectors points_;
  double support_;
  Eigen::Vector3d origin_;
  std::vector<Entry> entries_;
};

Vectors vectors(const std::vector<Vec3>& points);

}  // namespace drench::reference
