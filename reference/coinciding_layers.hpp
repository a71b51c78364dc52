#pragma once
// Layers of cloth that lie in one place, to the rounding of numbers: which way each of them leaves the other
// (contacts.md, 5b, 5c).

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "common.hpp"

namespace drench::reference {

/// Pairs are of a node and a triangle, or of two edges, as nodes 0 | 1 2 3 and 0 1 | 2 3.
class CoincidingLayers {
 public:
  using Nodes = std::array<Index, 4>;
  explicit CoincidingLayers(const ReferenceState& state);

  /// A node and a triangle that coincide: in the step the first goes by `way` (m) relative to the second.
  void leave(const Nodes& pair, const Eigen::Vector3d& way);
  /// The unit vector in which the first side goes, once all that coincide have told their ways; none if nothing tells.
  std::optional<Eigen::Vector3d> parting_direction(const Nodes& pair, bool edges) const;

 private:
  using Normals = std::array<Eigen::Vector3d, 2>;
  Eigen::Vector3d start(Index n) const;
  Eigen::Vector3d normal_at(std::initializer_list<Index> nodes) const;
  std::optional<Normals> normals(const Nodes& pair, bool edges) const;
  int later_side(const Nodes& pair) const { return piece_[pair[0]] > piece_[pair[3]] ? 0 : 1; }

  const ReferenceState& state_;
  std::vector<Index> piece_;          // of each node: the least node of its connected piece
  std::map<Index, double> to_front_;  // of a piece: how far it leaves the earlier ones to its front, m
};

}  // namespace drench::reference
