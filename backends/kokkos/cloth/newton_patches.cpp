#include "cloth/newton_patches.hpp"

#include <algorithm>

namespace drench::kokkos_backend {
namespace {

class Bisection {
 public:
  Bisection(const NodeGraph& near, Index patches, Index most)
      : near_(near), most_(static_cast<std::size_t>(most)), part_(near.size(), 0) {
    result_.start.push_back(0);
    std::vector<Index> all(near.size());
    for (std::size_t n = 0; n < all.size(); ++n) all[n] = static_cast<Index>(n);
    divide(std::move(all), patches);
  }
  NewtonPatches result() { return std::move(result_); }

 private:
  void divide(std::vector<Index> nodes, Index patches) {
    if (patches <= 1) {
      result_.order.insert(result_.order.end(), nodes.begin(), nodes.end());
      result_.start.push_back(static_cast<Index>(result_.order.size()));
      return;
    }
    const Index half = patches / 2;
    const std::vector<Index> order = by_distance(by_distance(nodes).back(), nodes);
    const auto first = static_cast<std::size_t>(half), all = static_cast<std::size_t>(patches);
    const std::size_t room = most_ * (all - first), least = order.size() > room ? order.size() - room : 0;
    const auto middle = static_cast<std::ptrdiff_t>(std::max(order.size() * first / all, least));
    divide({order.begin(), order.begin() + middle}, half);
    divide({order.begin() + middle, order.end()}, patches - half);
  }
  std::vector<Index> by_distance(const std::vector<Index>& nodes) { return by_distance(nodes.front(), nodes); }
  /// The nodes by their distance from the first in the graph of them alone; each further piece after the one before.
  std::vector<Index> by_distance(Index first, const std::vector<Index>& nodes) {
    ++number_;
    for (const Index n : nodes) part_[static_cast<std::size_t>(n)] = number_;
    std::vector<Index> order;
    const auto reach = [&](Index n) {
      if (part_[static_cast<std::size_t>(n)] != number_) return;
      part_[static_cast<std::size_t>(n)] = -1;
      order.push_back(n);
    };
    reach(first);
    std::size_t next = 0;
    for (const Index piece : nodes) {
      for (; next < order.size(); ++next)
        for (const Index other : near_[static_cast<std::size_t>(order[next])]) reach(other);
      reach(piece);
    }
    return order;
  }

  const NodeGraph& near_;
  std::size_t most_;
  std::vector<int> part_;  // of each node
  int number_ = 0;
  NewtonPatches result_;
};

}  // namespace

NewtonPatches make_newton_patches(const NodeGraph& near, Index patches, Index most) {
  return Bisection(near, patches, most).result();
}

std::vector<std::uint16_t> colours_of(const NodeGraph& near) {
  constexpr std::uint16_t none = 65535;
  std::vector<std::uint16_t> colour(near.size(), none);
  std::vector<char> taken;
  for (std::size_t n = 0; n < near.size(); ++n) {
    taken.assign(near[n].size() + 1, 0);
    for (const Index m : near[n]) {
      const std::uint16_t c = colour[static_cast<std::size_t>(m)];
      if (c < taken.size()) taken[c] = 1;
    }
    colour[n] = static_cast<std::uint16_t>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
  }
  return colour;
}

}  // namespace drench::kokkos_backend
