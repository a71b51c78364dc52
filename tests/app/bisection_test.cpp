// How space is cut for ranks (src/parallel/bisection.hpp), and how liquid lies in its parts (src/setup/rank_share.hpp).

#include "parallel/bisection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "setup/rank_share.hpp"

namespace drench::test {
namespace {

using Place = std::array<double, 3>;

bool holds(const RankPart& part, const Place& x, double reach = 0) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (reach > 0 && !(x[a] - part.min[a] > -reach && x[a] - part.max[a] < reach)) return false;
    if (reach == 0 && !(x[a] >= part.min[a] && x[a] < part.max[a])) return false;
  }
  return true;
}

std::vector<WeightedPoint> random_points(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0, 1), weight(0.5, 1.5);
  std::vector<WeightedPoint> points;
  for (int k = 0; k < count; ++k) points.push_back({{x(random), 3 * x(random), 2 * x(random)}, weight(random)});
  return points;
}

std::vector<Vec3> lattice(int nx, int ny, int nz) {
  std::vector<Vec3> places;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) places.push_back({x + 0.5, y + 0.5, z + 0.5});
  return places;
}

TEST(Bisection, PartsFillSpaceAndWeighTheSame) {
  const auto points = random_points(4000);
  for (const int ranks : {1, 2, 3, 5, 8, 13}) {
    const Bisection cuts(points, ranks);
    ASSERT_EQ(cuts.parts().size(), static_cast<std::size_t>(ranks));
    std::vector<double> weight(static_cast<std::size_t>(ranks));
    double all = 0;
    for (const WeightedPoint& p : points) {
      const auto rank = static_cast<std::size_t>(cuts.rank_of(p.at));
      for (std::size_t r = 0; r < weight.size(); ++r) EXPECT_EQ(holds(cuts.parts()[r], p.at), r == rank);
      weight[rank] += p.weight;
      all += p.weight;
    }
    for (const double w : weight) EXPECT_NEAR(w, all / ranks, 0.01 * all / ranks + 4) << ranks << " ranks";
  }
}

TEST(Bisection, FindsTheRanksNearAPlace) {
  const auto points = random_points(500);
  const Bisection cuts(points, 11);
  for (const WeightedPoint& p : points) {
    std::set<int> near, boxes;
    cuts.near(p.at, 0.2, [&](int r) { EXPECT_TRUE(near.insert(r).second); });
    for (int r = 0; r < 11; ++r)
      if (holds(cuts.parts()[static_cast<std::size_t>(r)], p.at, 0.2)) boxes.insert(r);
    EXPECT_EQ(near, boxes);
  }
}

TEST(Bisection, KeepsPlanesOfALatticeWholeAndPartsEqual) {
  const std::vector<Vec3> places = lattice(8, 16, 4);
  for (const int ranks : {2, 4, 8}) {
    const SpreadLiquid liquid = spread(places, ranks, 2.0002);
    for (const double n : liquid.owned) EXPECT_EQ(n, 512.0 / ranks);
  }
}

/// Of more points than a cut looks at, each stands for some.
TEST(Bisection, WeighsMoreThanItLooksAt) {
  const auto points = random_points(3'000'001);
  const Bisection cuts(points, 7);
  std::vector<double> weight(7);
  double all = 0;
  for (const WeightedPoint& p : points) {
    weight[static_cast<std::size_t>(cuts.rank_of(p.at))] += p.weight;
    all += p.weight;
  }
  for (const double w : weight) EXPECT_NEAR(w, all / 7, 0.005 * all / 7);
}

TEST(Bisection, WhatHasNoPlaceBelongsNowhere) {
  auto points = random_points(10);
  points[3].at[1] = NAN;
  const Bisection few(points, 256);  // more ranks than points
  points.erase(points.begin() + 3);
  int empty = 0;
  for (const RankPart& part : few.parts()) empty += part.min[0] > part.max[0] ? 1 : 0;
  EXPECT_GT(empty, 100);
  for (const WeightedPoint& p : points)
    EXPECT_EQ(
        std::count_if(few.parts().begin(), few.parts().end(), [&](const RankPart& part) { return holds(part, p.at); }),
        1);
  const Bisection none({}, 3);
  EXPECT_EQ(none.rank_of({4, 5, 6}), 0);
  EXPECT_FALSE(holds(none.parts()[1], {4, 5, 6}));
}

/// Layers of ghosts at a cut that lies on a plane: that plane and two more above it, and two below.
TEST(SpreadLiquid, CountsTheGhostsAtEachCut) {
  const SpreadLiquid two = spread(lattice(10, 20, 10), 2, 2.0002);
  EXPECT_EQ(two.owned, (std::vector<double>{1000, 1000}));
  EXPECT_EQ(two.ghosts, (std::vector<double>{300, 200}));
  const RankShare fullest = two.fullest();
  EXPECT_EQ(fullest.part, 0.5);
  EXPECT_NEAR(fullest.ghosts(2000), 300, 1e-6);
  EXPECT_NEAR(fullest.ghosts(8 * 2000), 4 * 300, 0.1 * 4 * 300) << "as a surface grows";
}

/// The expected shape against a counted one: a cube of 8 ranks has three faces each, one of 64 ranks inner parts with
/// six.
TEST(SpreadLiquid, IsWhatIsExpectedOfACube) {
  for (const int ranks : {8, 64}) {
    const std::vector<Vec3> places = lattice(48, 48, 48);
    const double n = static_cast<double>(places.size()), expected = expected_share(ranks, 2.0002).ghosts(n / 1.1),
                 counted = spread(places, ranks, 2.0002).fullest().ghosts(n);
    EXPECT_NEAR(expected, counted, 0.3 * counted) << ranks << " ranks";
  }
  EXPECT_EQ(expected_share(1, 2).ghosts(1e6), 0);
  EXPECT_LE(expected_share(64, 2).ghosts(100), 100) << "no more than the others have";
}

}  // namespace
}  // namespace drench::test
