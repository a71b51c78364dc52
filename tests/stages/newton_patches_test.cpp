// The patches and colours of nodes that Newton's method on a GPU works on; made on the host.

#include "cloth/newton_patches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace drench::test {
namespace {

using kokkos_backend::NodeGraph;

std::size_t at(Index n) { return static_cast<std::size_t>(n); }

/// A sheet of squares with one diagonal each.
NodeGraph sheet(Index width, Index height) {
  NodeGraph near(at(width * height));
  const auto join = [&](Index a, Index b) {
    near[at(a)].push_back(b);
    near[at(b)].push_back(a);
  };
  for (Index y = 0; y < height; ++y)
    for (Index x = 0; x < width; ++x) {
      const Index own = y * width + x;
      if (x + 1 < width) join(own, own + 1);
      if (y + 1 < height) join(own, own + width);
      if (x + 1 < width && y + 1 < height) join(own, own + width + 1);
    }
  return near;
}

/// Nodes that a walk from the first of them within the patch does not reach.
std::size_t unreached(const NodeGraph& near, const std::vector<Index>& patch) {
  std::vector<char> inside(near.size(), 0);
  for (const Index n : patch) inside[at(n)] = 1;
  std::vector<Index> reached{patch.front()};
  inside[at(patch.front())] = 0;
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const Index m : near[at(reached[k])])
      if (inside[at(m)] != 0) {
        inside[at(m)] = 0;
        reached.push_back(m);
      }
  return patch.size() - reached.size();
}

/// Every node is in one patch, no patch is larger than allowed. Returns the share of edges that join two patches.
double cut_of(const NodeGraph& near, Index patches, Index most, bool connected) {
  const kokkos_backend::NewtonPatches made = kokkos_backend::make_newton_patches(near, patches, most);
  EXPECT_EQ(made.start.size(), at(patches) + 1);
  std::vector<Index> sorted = made.order, all(near.size());
  std::iota(all.begin(), all.end(), Index{0});
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, all);
  std::vector<Index> patch_of(near.size(), -1);
  std::size_t apart = 0;
  for (Index p = 0; p < patches; ++p) {
    const std::vector<Index> own(made.order.begin() + made.start[at(p)], made.order.begin() + made.start[at(p + 1)]);
    EXPECT_LE(own.size(), at(most)) << "patch " << p;
    EXPECT_FALSE(own.empty()) << "patch " << p;
    for (const Index n : own) patch_of[at(n)] = p;
    if (!own.empty()) apart += unreached(near, own);
  }
  EXPECT_LE(apart, connected ? near.size() / 10 : near.size());
  std::size_t edges = 0, cut = 0;
  for (std::size_t n = 0; n < near.size(); ++n)
    for (const Index m : near[n]) {
      ++edges;
      cut += patch_of[n] != patch_of[at(m)];
    }
  return edges > 0 ? double(cut) / double(edges) : 0;
}

}  // namespace

TEST(newton_patches, hold_every_node_once) {
  EXPECT_LT(cut_of(sheet(40, 30), 36, 34, true), 0.4);  // rows of 34 nodes would cut two thirds of the edges
  EXPECT_LT(cut_of(sheet(31, 17), 16, 34, true), 0.4);
  EXPECT_EQ(cut_of(sheet(5, 5), 1, 34, true), 0);
  EXPECT_EQ(cut_of(NodeGraph(3), 3, 1, false), 0);  // nodes without edges
}

TEST(newton_patches, of_pieces_apart) {
  NodeGraph near = sheet(9, 9);
  const Index first = static_cast<Index>(near.size());
  for (std::vector<Index> row : sheet(20, 3)) {
    for (Index& n : row) n += first;
    near.push_back(row);
  }
  EXPECT_LT(cut_of(near, 5, 34, false), 0.4);
}

TEST(newton_patches, neighbours_have_different_colours) {
  for (const NodeGraph& near : {sheet(20, 13), NodeGraph(4)}) {
    const std::vector<std::uint16_t> colour = kokkos_backend::colours_of(near);
    std::size_t most = 0;
    for (std::size_t n = 0; n < near.size(); ++n) {
      most = std::max(most, near[n].size());
      for (const Index m : near[n]) EXPECT_NE(colour[n], colour[at(m)]);
    }
    EXPECT_LE(*std::max_element(colour.begin(), colour.end()), most);
  }
}

}  // namespace drench::test
