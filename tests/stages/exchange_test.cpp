// The cuts of space among ranks: what each owns, and that every point has one owner.

#include "particles/exchange.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace drench::test {
namespace {

using kokkos_backend::RankBox;
using kokkos_backend::Real;
using kokkos_backend::Real3;

using Points = std::vector<WeightedPoint>;

constexpr Real infinity = std::numeric_limits<Real>::infinity();
constexpr int numbers_of_ranks[] = {1, 2, 3, 4, 5, 7, 8, 16, 33};

Points random_points(std::size_t count, const Real3& sides, double most_weight = 1, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<Real> part(-1, 1);
  std::uniform_real_distribution<double> weight(most_weight == 1 ? 1 : 1 / most_weight, most_weight);
  Points points;
  for (std::size_t k = 0; k < count; ++k)
    points.push_back({{sides.x * part(random), sides.y * part(random), sides.z * part(random)}, weight(random)});
  return points;
}

Points lattice(int nx, int ny, int nz) {
  Points points;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k)
        points.push_back({{Real(0.02) * Real(i), Real(0.02) * Real(j), Real(0.02) * Real(k)}, 1});
  return points;
}

Real3 real(const std::array<double, 3>& x) { return {Real(x[0]), Real(x[1]), Real(x[2])}; }

/// The cuts as the backend takes them.
std::vector<RankBox> bisected(const Points& points, int ranks) {
  const Bisection cuts(points, ranks);
  std::vector<RankBox> boxes;
  for (const RankPart& part : cuts.parts()) boxes.push_back({real(part.min), real(part.max)});
  return boxes;
}

int owners(const std::vector<RankBox>& boxes, const Real3& x) {
  return static_cast<int>(std::count_if(boxes.begin(), boxes.end(), [&](const RankBox& b) { return b.holds(x); }));
}

std::vector<double> weights(const std::vector<RankBox>& boxes, const Points& points) {
  std::vector<double> sums(boxes.size());
  for (const WeightedPoint& p : points)
    for (std::size_t r = 0; r < boxes.size(); ++r)
      if (boxes[r].holds(real(p.at))) sums[r] += p.weight;
  return sums;
}

/// The fullest over the mean.
double imbalance(const Points& points, int ranks) {
  const std::vector<double> all = weights(bisected(points, ranks), points);
  double sum = 0;
  for (const double w : all) sum += w;
  return *std::max_element(all.begin(), all.end()) * ranks / sum;
}

/// Every place has one owner: the points, the corners and faces of all boxes and next to them, and far away.
void expect_one_owner(const std::vector<RankBox>& boxes, const Points& points) {
  std::vector<Real> at[3];
  for (auto& a : at) a = {Real(-1e30), 0, Real(1e30), Real(0.37), -infinity};
  for (const RankBox& b : boxes)
    for (const Real3& corner : {b.min, b.max}) {
      const Real values[3] = {corner.x, corner.y, corner.z};
      for (std::size_t a = 0; a < 3; ++a)
        for (const Real v : {std::nextafter(values[a], -infinity), values[a], std::nextafter(values[a], infinity)})
          if (std::isfinite(v)) at[a].push_back(v);
    }
  for (auto& a : at) {
    std::sort(a.begin(), a.end());
    a.erase(std::unique(a.begin(), a.end()), a.end());
  }
  for (const Real x : at[0])
    for (const Real y : at[1])
      for (const Real z : at[2]) ASSERT_EQ(owners(boxes, {x, y, z}), 1) << x << " " << y << " " << z;
  for (const WeightedPoint& p : points)
    if (std::isfinite(p.at[0] + p.at[1] + p.at[2])) {
      ASSERT_EQ(owners(boxes, real(p.at)), 1) << p.at[0] << " " << p.at[1] << " " << p.at[2];
    }
}

}  // namespace

TEST(exchange, the_ranks_boxes_fill_space_and_do_not_overlap) {
  for (const int ranks : numbers_of_ranks) {
    SCOPED_TRACE(ranks);
    for (const Points& points : {random_points(3000, {1, 1, 1}), random_points(1000, {Real(1e-3), 5, Real(0.1)}, 50),
                                 lattice(9, 10, 11), lattice(40, 1, 1), random_points(5, {1, 1, 1})}) {
      const auto boxes = bisected(points, ranks);
      ASSERT_EQ(boxes.size(), static_cast<std::size_t>(ranks));
      expect_one_owner(boxes, points);
    }
  }
}

TEST(exchange, each_rank_has_about_the_same) {
  for (const int ranks : numbers_of_ranks) {
    EXPECT_LT(imbalance(random_points(20000, {1, 1, 1}), ranks), 1.01) << ranks;
    EXPECT_LT(imbalance(random_points(20000, {4, Real(0.1), 1}), ranks), 1.01) << ranks;
    EXPECT_LT(imbalance(random_points(20000, {1, 1, 2}, 10), ranks), 1.03) << ranks << ", weights";
    // Layers are not cut: on every side of a part half of one may be too many.
    const double layers = std::cbrt(64.0 * 48 * 33 / ranks);
    EXPECT_LT(imbalance(lattice(64, 48, 33), ranks), 1 + 2 / layers) << ranks;
  }
  // Counts that a sum of weights meets exactly.
  for (const int ranks : {2, 4, 8, 16}) EXPECT_EQ(imbalance(lattice(64, 1, 1), ranks), 1) << ranks;
}

TEST(exchange, cuts_go_across_the_longest_side) {
  for (int axis = 0; axis < 3; ++axis) {
    const Real3 sides{axis == 0 ? Real(8) : Real(1), axis == 1 ? Real(8) : Real(1), axis == 2 ? Real(8) : Real(1)};
    for (const RankBox& b : bisected(random_points(5000, sides), 4)) {
      const Real low[] = {b.min.x, b.min.y, b.min.z}, high[] = {b.max.x, b.max.y, b.max.z};
      for (int a = 0; a < 3; ++a) {
        const bool whole = low[a] == -infinity && high[a] == infinity;
        EXPECT_EQ(whole, a != axis) << a;
      }
    }
  }
}

TEST(exchange, points_at_one_place_and_none_at_all_have_one_owner) {
  const Points same(100, {{Real(0.1), Real(-0.2), Real(0.3)}, 1});
  Points two = same;
  two.resize(150, {{Real(0.1), Real(0.2), Real(0.3)}, 1});
  for (const int ranks : numbers_of_ranks) {
    SCOPED_TRACE(ranks);
    for (const Points& points : {same, two, Points{}, Points(1, {{1, 2, 3}, 4})})
      expect_one_owner(bisected(points, ranks), points);
    const std::vector<double> all = weights(bisected(same, ranks), same);
    EXPECT_EQ(*std::max_element(all.begin(), all.end()), 100);
  }
  const RankBox first = bisected({}, 3)[0];
  EXPECT_TRUE(first.holds({5, -7, Real(1e20)})) << "without points the first has all of space";
}

TEST(exchange, as_many_points_as_ranks_are_one_each) {
  for (const int ranks : {2, 3, 4, 8}) {
    const std::vector<double> all = weights(bisected(lattice(ranks, 1, 1), ranks), lattice(ranks, 1, 1));
    EXPECT_EQ(all, std::vector<double>(static_cast<std::size_t>(ranks), 1)) << ranks;
  }
}

TEST(exchange, what_is_no_number_does_not_move_a_cut) {
  const Points finite = random_points(500, {1, 2, 1});
  Points with_others = finite;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (const Real bad : {nan, infinity, -infinity})
    for (std::size_t a = 0; a < 3; ++a) {
      WeightedPoint p{{0, 0, 0}, 1};
      p.at[a] = bad;
      with_others.insert(with_others.begin() + 100, p);
      with_others.push_back(p);
    }
  for (const int ranks : {2, 5}) {
    const auto one = bisected(finite, ranks), other = bisected(with_others, ranks);
    for (std::size_t r = 0; r < one.size(); ++r) {
      const Real a[] = {one[r].min.x, one[r].min.y, one[r].min.z, one[r].max.x, one[r].max.y, one[r].max.z};
      const Real b[] = {other[r].min.x, other[r].min.y, other[r].min.z, other[r].max.x, other[r].max.y, other[r].max.z};
      EXPECT_TRUE(std::equal(std::begin(a), std::end(a), b)) << r;
    }
  }
  expect_one_owner(bisected(Points(3, {{nan, 0, infinity}, 1}), 4), {});
}

/// The order of the points, which depends on who sends them, must not move a cut.
TEST(exchange, the_order_of_points_does_not_matter) {
  Points points = lattice(12, 12, 12);
  const auto before = bisected(points, 6);
  std::mt19937 random(4);
  std::shuffle(points.begin(), points.end(), random);
  const auto after = bisected(points, 6);
  for (std::size_t r = 0; r < before.size(); ++r) {
    EXPECT_EQ(before[r].min.x, after[r].min.x);
    EXPECT_EQ(before[r].max.x, after[r].max.x);
    EXPECT_EQ(before[r].min.y, after[r].min.y);
    EXPECT_EQ(before[r].max.y, after[r].max.y);
    EXPECT_EQ(before[r].min.z, after[r].min.z);
    EXPECT_EQ(before[r].max.z, after[r].max.z);
  }
}

/// A ghost's box is grown by the reach; the empty box of a rank without a part is near to nothing.
TEST(exchange, near_is_the_box_grown_by_the_reach) {
  const RankBox box{{0, 0, 0}, {1, 1, infinity}};
  const Real h = Real(0.25);
  EXPECT_TRUE(box.near({Real(-0.24), Real(1.24), 9}, h));
  EXPECT_FALSE(box.near({Real(-0.26), Real(0.5), 9}, h));
  EXPECT_FALSE(box.near({Real(0.5), Real(1.26), 9}, h));
  EXPECT_FALSE(box.near({Real(0.5), Real(0.5), Real(-0.26)}, h));
  EXPECT_TRUE(box.near({Real(0.5), Real(0.5), Real(1e20)}, h));
  const auto boxes = bisected(Points(1, {{1, 2, 3}, 1}), 4);
  const auto empty = std::find_if(boxes.begin(), boxes.end(), [](const RankBox& b) { return b.min.x == infinity; });
  ASSERT_NE(empty, boxes.end());
  for (const Real x : {Real(0), Real(1e30), Real(-1e30)}) EXPECT_FALSE(empty->near({x, x, x}, 1));
}

}  // namespace drench::test
