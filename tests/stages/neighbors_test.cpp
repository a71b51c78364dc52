// Stage neighbors: neighbour sets against brute force, and backend against reference.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "device_copy.hpp"
#include "primitives/neighbor_list.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

using kokkos_backend::Array;
using kokkos_backend::Real;
using kokkos_backend::Real3;
using Pairs = std::set<std::pair<Index, Index>>;

constexpr Real support = Real(0.25);  // exact in binary, so that cell faces are hit exactly

Pairs brute_force(const std::vector<Vec3>& points) {
  Pairs pairs;
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i)
    for (Index j = 0; j < static_cast<Index>(points.size()); ++j) {
      const Real3 r = kokkos_backend::to_real(points[std::size_t(i)]) - kokkos_backend::to_real(points[std::size_t(j)]);
      if (i != j && dot(r, r) < support * support) pairs.insert({i, j});
    }
  return pairs;
}

struct Found {
  Pairs pairs;
  std::size_t entries = 0;  // more than pairs.size() if a neighbour is listed twice
  bool hashed = false;
};

Found from_cells(const std::vector<Vec3>& points) {
  const auto n = static_cast<Index>(points.size());
  const Array<Real3> x = kokkos_backend::to_device3("points", points);
  kokkos_backend::CellTable table;
  table.build(x, n, support);
  kokkos_backend::NeighborList list;
  kokkos_backend::build_neighbor_list({&list, x, n, table.view(), true}, support);
  Found found;
  found.hashed = table.view().hashed != 0;
  if (n == 0) return found;
  const auto count = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), list.count);
  const auto items = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), list.list);
  for (Index i = 0; i < n; ++i)
    for (Index k = 0; k < count(i); ++k, ++found.entries) found.pairs.insert({i, items(i, k)});
  return found;
}

std::vector<Vec3> random_points(int n, double from, double to, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> axis(from, to);
  std::vector<Vec3> points(static_cast<std::size_t>(n));
  for (Vec3& p : points) p = {axis(random), axis(random), axis(random)};
  return points;
}

void expect_equal_sets(const std::vector<Vec3>& points, bool expect_pairs = true) {
  const Pairs expected = brute_force(points);
  const Found found = from_cells(points);
  EXPECT_EQ(found.pairs, expected);
  EXPECT_EQ(found.entries, expected.size());
  EXPECT_EQ(!expected.empty(), expect_pairs);
}

/// The two sets of points that a list of the backends pairs, in double.
struct Sides {
  std::vector<Vec3> from, to;
};

Sides sides_of(const std::string& list, const Model& model, const HostState& s) {
  std::vector<Vec3> samples;
  for (std::size_t p = 0; p < model.samples.triangle.size(); ++p) {
    const auto& nodes = model.mesh.triangle[std::size_t(model.samples.triangle[p])];
    Vec3 x{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        x[c] += model.samples.weight[p][k] * s.node_position[std::size_t(nodes[k])][c];
    samples.push_back(x);
  }
  const auto named = [&](const std::string& name) {
    return name == "fluid" ? s.fluid_position : name == "boundary" ? s.boundary_position : samples;
  };
  const auto at = list.find('_');
  return {named(list.substr(0, at)), named(list.substr(at + 1))};
}

double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

double largest(const Vec3& a, const Vec3& b) {
  double x = 0;
  for (std::size_t c = 0; c < 3; ++c) x = std::max({x, std::fabs(a[c]), std::fabs(b[c])});
  return x;
}

}  // namespace

TEST(neighbors, random_points) { expect_equal_sets(random_points(1500, 0, 1.5, 1)); }
TEST(neighbors, negative_coordinates) { expect_equal_sets(random_points(1023, -1.7, 0.3, 2)); }
TEST(neighbors, number_that_is_no_power_of_two) { expect_equal_sets(random_points(1025, 0, 1, 3)); }

TEST(neighbors, points_on_cell_faces) {
  std::vector<Vec3> points;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j)
      for (int k = -4; k <= 4; ++k) points.push_back({0.125 * i, 0.125 * j, 0.125 * k});
  expect_equal_sets(points);
}

TEST(neighbors, coincident_points) {
  std::vector<Vec3> points(70, Vec3{0.5, -0.5, 0.25});
  points.push_back({0.6, -0.5, 0.25});
  expect_equal_sets(points);
}

TEST(neighbors, no_point_and_one_point) {
  expect_equal_sets({}, false);
  expect_equal_sets({{0.1, 0.2, -0.3}}, false);
}

TEST(neighbors, sparse_and_unbounded_domain_is_hashed) {
  std::vector<Vec3> points = random_points(400, -0.5, 0.5, 4);
  for (const Vec3& p : random_points(400, -0.5, 0.5, 5)) points.push_back({p[0] + 3000, p[1] - 2000, p[2] + 1000});
  for (const Vec3& p : random_points(300, -4000, 4000, 6)) points.push_back(p);
  expect_equal_sets(points);
  EXPECT_TRUE(from_cells(points).hashed);
}

TEST(neighbors, a_point_that_is_not_finite_does_not_disturb_the_others) {
  std::vector<Vec3> points = random_points(300, 0, 1, 7);
  points.push_back({std::numeric_limits<double>::quiet_NaN(), 0.5, 0.5});
  points.push_back({std::numeric_limits<double>::infinity(), 0.5, 0.5});
  expect_equal_sets(points);
}

TEST(neighbors, lists_agree_with_the_reference) {
  auto setup = setup_from(wet_scene());
  for (Vec3& x : setup.state.fluid_position) x[1] -= 0.03;  // down to the sphere, on both sides of the sheet
  const auto reference = make_reference_backend(setup.model);
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  for (Backend* b : {reference.get(), backend.get()}) {
    b->upload(setup.state);
    b->run(Stage::neighbors, {}, report);
    b->run(Stage::porous_neighbors, {}, report);
  }
  const HostState state = reference->download();
  const double h = setup.model.support;
  for (const char* list :
       {"fluid_fluid", "fluid_boundary", "fluid_sample", "sample_fluid", "sample_sample", "sample_boundary"}) {
    const auto a = reference->neighbor_pairs(list), b = backend->neighbor_pairs(list);
    const Pairs expected(a.begin(), a.end()), found(b.begin(), b.end());
    EXPECT_EQ(found.size(), b.size()) << list << " names a pair twice";
    std::vector<std::pair<Index, Index>> only_one;
    std::set_symmetric_difference(expected.begin(), expected.end(), found.begin(), found.end(),
                                  std::back_inserter(only_one));
    // The lists may differ only in pairs whose distance rounds across h; the blocks' lattice (h = 2 d) has many. With X
    // the largest coordinate at hand and u = epsilon/2, a stored point is off by u X along each axis, a sample made
    // from rounded nodes (less than 2 h away) and weights by 5 u X, so a separation by at most √3 · 10 u X; r² and h²
    // round by some u more.
    const Sides sides = sides_of(list, setup.model, state);
    const auto lies_at_h = [&](const std::pair<Index, Index>& p) {
      const Vec3 &from = sides.from.at(std::size_t(p.first)), &to = sides.to.at(std::size_t(p.second));
      const double rounding = std::numeric_limits<Real>::epsilon() * (9 * (largest(from, to) + 2 * h) + 2 * h);
      return std::fabs(distance(from, to) - h) <= rounding;
    };
    for (const auto& p : only_one)
      EXPECT_TRUE(lies_at_h(p)) << list << " " << p.first << " " << p.second << " is only in the "
                                << (expected.contains(p) ? "reference's" : "backend's") << " list";
    EXPECT_GT(std::count_if(expected.begin(), expected.end(), [&](const auto& p) { return !lies_at_h(p); }), 100)
        << list << " has hardly a pair that had to be found";
  }
}

}  // namespace drench::test
