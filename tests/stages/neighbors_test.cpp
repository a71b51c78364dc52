// Stage neighbors: neighbour sets against brute force, and backend against reference.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "core/host_copy.hpp"
#include "core/neighbor_search.hpp"
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
  kokkos_backend::build_neighbor_list({&list, &x, n, table.view(), true}, support);
  Found found;
  found.hashed = table.view().hashed != 0;
  const std::vector<std::vector<Index>> rows = kokkos_backend::rows_on_host(list);
  for (Index i = 0; i < n; ++i)
    for (const Index j : rows[static_cast<std::size_t>(i)]) {
      found.pairs.insert({i, j});
      ++found.entries;
    }
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

/// One list through states with more and fewer rows, none, and rows that are hundreds long.
TEST(neighbors, a_list_that_is_filled_again_has_what_a_new_one_has) {
  kokkos_backend::NeighborList list;
  kokkos_backend::CellTable table;
  const auto expect_rows_of = [&](const std::vector<Vec3>& points) {
    const auto n = static_cast<Index>(points.size());
    const Array<Real3> x = kokkos_backend::to_device3("points", points);
    table.build(x, n, support);
    kokkos_backend::build_neighbor_list({&list, &x, n, table.view(), true}, support);
    const std::vector<std::vector<Index>> rows = kokkos_backend::rows_on_host(list);
    ASSERT_EQ(rows.size(), points.size());
    Pairs found;
    std::size_t entries = 0;
    for (Index i = 0; i < n; ++i)
      for (const Index j : rows[static_cast<std::size_t>(i)]) {
        found.insert({i, j});
        ++entries;
      }
    EXPECT_EQ(found, brute_force(points));
    EXPECT_EQ(entries, found.size());
  };
  std::vector<Vec3> crowd = random_points(600, 0, 0.1, 9);  // each sees all others
  for (const Vec3& p : random_points(333, 0, 1, 10)) crowd.push_back(p);
  expect_rows_of(random_points(500, 0, 1, 8));
  expect_rows_of({});
  expect_rows_of(random_points(77, 0, 2, 11));
  expect_rows_of(crowd);
  expect_rows_of(crowd);
  expect_rows_of(random_points(1000, 0, 3, 12));
  expect_rows_of({{0, 0, 0}});
  std::vector<Vec3> hashed = random_points(400, -0.5, 0.5, 14);
  for (const Vec3& p : random_points(400, -4000, 4000, 15)) hashed.push_back(p);
  expect_rows_of(hashed);
  EXPECT_TRUE(table.view().hashed);
  expect_rows_of(random_points(1001, 0, 0.8, 13));
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
  for (const std::string& list : neighbor_list_names()) {
    const ListDifference d = compare_list(list, setup.model, state, *reference, *backend, backend_precision());
    EXPECT_EQ(d.repeated, 0u) << list << " names a pair twice";
    EXPECT_EQ(testing::PrintToString(d.wrong), "{}") << list << ": pairs that only one has";
    EXPECT_GT(d.clear_pairs, 100u) << list << " has hardly a pair that had to be found";
  }
}

TEST(neighbors, a_pair_that_only_one_has_is_found) {
  const auto setup = setup_from(wet_scene());
  const auto reference = make_reference_backend(setup.model);
  const auto backend = make_kokkos_backend(setup.model);
  StepReport report;
  reference->upload(setup.state);
  reference->run(Stage::neighbors, {}, report);
  HostState moved = setup.state;
  moved.fluid_position[0][0] += 100;
  backend->upload(moved);
  backend->run(Stage::neighbors, {}, report);
  const ListDifference d =
      compare_list("fluid_fluid", setup.model, setup.state, *reference, *backend, backend_precision());
  EXPECT_GT(d.wrong.size(), 10u);
  for (const auto& [i, j] : d.wrong) EXPECT_TRUE(i == 0 || j == 0);
}

}  // namespace drench::test
