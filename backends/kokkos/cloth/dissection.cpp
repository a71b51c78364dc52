#include "cloth/dissection.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

namespace drench::kokkos_backend {
namespace {

/// How many steps each node of `nodes` is from `from`, over nodes of the same label; −1: no way leads there.
std::vector<Index> steps_from(const NodeGraph& near, const std::vector<Index>& label, Index from) {
  std::vector<Index> steps(near.size(), -1), queue{from};
  steps[at(from)] = 0;
  for (std::size_t k = 0; k < queue.size(); ++k)
    for (const Index j : near[at(queue[k])])
      if (label[at(j)] == label[at(from)] && steps[at(j)] < 0) {
        steps[at(j)] = steps[at(queue[k])] + 1;
        queue.push_back(j);
      }
  return steps;
}

/// The connected set of `first`, from one end of it to the other.
std::vector<Index> sorted_set(const NodeGraph& near, const std::vector<Index>& label, Index first) {
  const auto farthest = [](const std::vector<Index>& steps) {
    return static_cast<Index>(std::max_element(steps.begin(), steps.end()) - steps.begin());
  };
  const Index one = farthest(steps_from(near, label, first));
  const std::vector<Index> from_one = steps_from(near, label, one);
  const std::vector<Index> from_other = steps_from(near, label, farthest(from_one));
  std::vector<Index> nodes;
  std::vector<double> height(near.size()), next(near.size());
  for (std::size_t i = 0; i < near.size(); ++i)
    if (from_one[i] >= 0) {
      nodes.push_back(static_cast<Index>(i));
      height[i] = double(from_one[i] - from_other[i]);
    }
  for (int k = 0; k < 30; ++k) {  // smooth, so that the cut is short
    for (const Index i : nodes) {
      double sum = height[at(i)];
      int count = 1;
      for (const Index j : near[at(i)])
        if (label[at(j)] == label[at(i)]) {
          sum += height[at(j)];
          ++count;
        }
      next[at(i)] = sum / count;
    }
    std::swap(height, next);
  }
  std::stable_sort(nodes.begin(), nodes.end(), [&](Index a, Index b) { return height[at(a)] < height[at(b)]; });
  return nodes;
}

/// Splits the nodes of a label: half of them keep it, others get `other`, and those of these that touch the first
/// `between`.
void bisect(const NodeGraph& near, std::vector<Index>& label, Index own, Index other, Index between) {
  std::vector<Index> nodes;
  std::vector<bool> seen(near.size());
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (label[i] != own || seen[i]) continue;
    for (const Index n : sorted_set(near, label, static_cast<Index>(i))) {
      seen[at(n)] = true;
      nodes.push_back(n);
    }
  }
  const std::size_t half = nodes.size() / 2;
  for (std::size_t k = half; k < nodes.size(); ++k) label[at(nodes[k])] = other;
  std::vector<Index> cut;
  for (std::size_t k = half; k < nodes.size(); ++k)
    for (const Index j : near[at(nodes[k])])
      if (label[at(j)] == own) {
        cut.push_back(nodes[k]);
        break;
      }
  for (const Index n : cut) label[at(n)] = between;
}

/// Minimum degree among the nodes of a part; `next`: the place of the first.
void order_part(const NodeGraph& near, const std::vector<Index>& part, Index own, Index& next,
                std::vector<Index>& place) {
  std::vector<Index> nodes, number(near.size(), -1);
  for (std::size_t i = 0; i < near.size(); ++i)
    if (part[i] == own) {
      number[i] = static_cast<Index>(nodes.size());
      nodes.push_back(static_cast<Index>(i));
    }
  const auto size = static_cast<int>(nodes.size());
  if (size == 0) return;
  std::vector<Eigen::Triplet<double, int>> entries;
  for (int k = 0; k < size; ++k) {
    entries.emplace_back(k, k, 1.0);
    for (const Index j : near[at(nodes[at(k)])])
      if (number[at(j)] >= 0) entries.emplace_back(k, number[at(j)], 1.0);
  }
  Eigen::SparseMatrix<double> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  for (int k = 0; k < size; ++k) place[at(nodes[at(order.indices()[k])])] = next + k;
  next += size;
}

}  // namespace

Dissection dissect(const NodeGraph& near) {
  constexpr std::size_t least = 300;  // nodes that are worth two parts
  constexpr Index most_levels = 3;
  Dissection d;
  while (d.levels < most_levels && (near.size() >> d.levels) >= least) ++d.levels;
  d.part.assign(near.size(), 0);
  d.place.resize(near.size());
  for (Index level = d.levels; level > 0; --level) {
    const Index halved = d.parts_on(level);
    for (Index p = 0; p < halved; ++p) bisect(near, d.part, p, halved + p, d.first_part(level) + p);
  }
  Index next = 0;
  for (Index p = 0; p < d.parts(); ++p) order_part(near, d.part, p, next, d.place);
  return d;
}

NodeGraph reordered(const NodeGraph& near, const std::vector<Index>& place) {
  NodeGraph out(near.size());
  for (std::size_t i = 0; i < near.size(); ++i)
    for (const Index j : near[i]) out[at(place[i])].push_back(place[at(j)]);
  return out;
}

std::vector<Index> elimination_tree(const NodeGraph& near) {  // Liu's algorithm
  std::vector<Index> parent(near.size(), -1), root(near.size(), -1);
  for (Index i = 0; i < static_cast<Index>(near.size()); ++i)
    for (Index j : near[at(i)])
      while (j >= 0 && j < i) {
        const Index next = std::exchange(root[at(j)], i);
        if (next < 0) parent[at(j)] = i;
        j = next;
      }
  return parent;
}

std::vector<Index> postorder(const std::vector<Index>& parent) {
  NodeGraph children(parent.size() + 1);
  for (std::size_t i = 0; i < parent.size(); ++i)
    children[parent[i] < 0 ? parent.size() : at(parent[i])].push_back(static_cast<Index>(i));
  std::vector<Index> place(parent.size()), stack = children.back();
  auto next = static_cast<Index>(parent.size());
  while (!stack.empty()) {  // from the last place down: a parent, then its children
    const Index i = stack.back();
    stack.pop_back();
    place[at(i)] = --next;
    stack.insert(stack.end(), children[at(i)].begin(), children[at(i)].end());
  }
  return place;
}

}  // namespace drench::kokkos_backend
