#pragma once
// Disjoint sets.

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// Sets of numbers that are united step by step; each is named by its lowest.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  Index root(Index i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  void unite(Index a, Index b) {
    a = root(a);
    b = root(b);
    parent_[at(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace drench
