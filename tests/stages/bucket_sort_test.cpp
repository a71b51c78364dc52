// The sorts behind a cell table: each against a sort on the host, and so all of them alike, bit for bit.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>

#include "core/cell_table.hpp"
#include "core/host_copy.hpp"
#include "pipeline/pipeline.hpp"
#include "stage_compare.hpp"

namespace drench::test {
namespace {

using kokkos_backend::Array;
using kokkos_backend::CellCoord;
using kokkos_backend::CellTable;
using kokkos_backend::CellTableView;
using kokkos_backend::Real;
using kokkos_backend::Real3;

constexpr Real edge = Real(0.25);  // exact in binary, so that cell faces are hit exactly
constexpr SortMethod sorts[] = {SortMethod::automatic, SortMethod::counting, SortMethod::radix, SortMethod::bitonic,
                                SortMethod::bitonic_naive};

const char* name(SortMethod sort) {
  const char* names[] = {"auto", "counting", "radix", "bitonic", "bitonic_naive"};
  return names[static_cast<int>(sort)];
}

/// What kernels read of a table, on the host.
struct Copy {
  bool hashed = false;
  std::vector<Index> start, item;
  std::vector<std::array<int, 3>> coord;  // of a hashed table
  std::vector<Real> position;             // of the entries, as they lie in `point`
  bool operator==(const Copy&) const = default;
};

Copy copy_of(const CellTableView& t, Index count) {
  Copy c;
  if (t.buckets == 0) return c;
  c.hashed = t.hashed != 0;
  const auto part = [](const auto& a, Index n) {
    return Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), Kokkos::subview(a, Kokkos::make_pair(Index(0), n)));
  };
  const auto start = part(t.start, t.buckets + 1), item = part(t.item, count);
  kokkos_backend::Array<kokkos_backend::Real3> points("points", static_cast<std::size_t>(count));
  const kokkos_backend::CellPoints from = t.point;
  Kokkos::parallel_for(
      kokkos_backend::Range(0, count), KOKKOS_LAMBDA(const Index e) { points(e) = from(e); });
  const auto point = part(points, count);
  c.start.assign(start.data(), start.data() + t.buckets + 1);
  c.item.assign(item.data(), item.data() + count);
  if (c.hashed) {
    const auto coord = part(t.coord, count);
    for (Index e = 0; e < count; ++e) c.coord.push_back({coord(e).x, coord(e).y, coord(e).z});
  }
  for (Index e = 0; e < count; ++e) {
    for (const Real p : {point(e).x, point(e).y, point(e).z})
      c.position.push_back(p == p ? p : Real(-12345));  // NaN differs from itself
  }
  return c;
}

/// The table that has to come out: from the view's origin and buckets, and a sort of the standard library.
Copy expected_table(const CellTableView& t, const std::vector<Vec3>& points, const std::vector<std::int64_t>& key) {
  Copy c;
  if (points.empty()) return c;
  const auto n = points.size();
  std::vector<CellCoord> cell(n);
  std::vector<Index> bucket(n);
  for (std::size_t i = 0; i < n; ++i) {
    const CellCoord at = t.cell_of(kokkos_backend::to_real(points[i]));
    cell[i] = t.hashed ? at : CellCoord{0, 0, 0};
    bucket[i] = std::max(t.bucket_of(at), 0);
  }
  c.hashed = t.hashed != 0;
  c.item.resize(n);
  std::iota(c.item.begin(), c.item.end(), 0);
  const auto rank = [&](Index i) {
    const auto k = static_cast<std::size_t>(i);
    return std::tuple(bucket[k], cell[k].z, cell[k].y, cell[k].x, key.empty() ? std::int64_t{i} : key[k]);
  };
  std::sort(c.item.begin(), c.item.end(), [&](Index i, Index j) { return rank(i) < rank(j); });
  c.start.assign(static_cast<std::size_t>(t.buckets) + 1, 0);
  for (const Index b : bucket) ++c.start[static_cast<std::size_t>(b) + 1];
  std::partial_sum(c.start.begin(), c.start.end(), c.start.begin());
  for (const Index i : c.item) {
    const auto k = static_cast<std::size_t>(i);
    if (c.hashed) c.coord.push_back({cell[k].x, cell[k].y, cell[k].z});
    const Real3 x = kokkos_backend::to_real(points[k]);
    for (const Real p : {x.x, x.y, x.z}) c.position.push_back(p == p ? p : Real(-12345));
  }
  return c;
}

void expect_table(CellTable& table, const std::vector<Vec3>& points, const std::vector<std::int64_t>& key) {
  const auto n = static_cast<Index>(points.size());
  const Array<Real3> x = kokkos_backend::to_device3("points", points);
  const Array<std::int64_t> k = kokkos_backend::to_device<std::int64_t>("keys", key);
  table.build(x, n, edge, k);
  const Copy first = copy_of(table.view(), n);
  const Copy expected = expected_table(table.view(), points, key);
  EXPECT_EQ(first.hashed, expected.hashed);
  EXPECT_EQ(first.item, expected.item);
  EXPECT_EQ(first.start, expected.start);
  EXPECT_EQ(first.coord, expected.coord);
  EXPECT_EQ(first.position, expected.position);
  table.build(x, n, edge, k);
  EXPECT_TRUE(copy_of(table.view(), n) == first) << "a second run differs";
}

/// Ids that are in no order, and above 2^32.
std::vector<std::int64_t> ids(std::size_t n) {
  std::vector<std::int64_t> id(n);
  for (std::size_t i = 0; i < n; ++i) id[i] = static_cast<std::int64_t>(i) * 2654435769 + (std::int64_t{1} << 40);
  std::shuffle(id.begin(), id.end(), std::mt19937(11));
  return id;
}

void expect_all_sorts(const std::vector<Vec3>& points) {
  for (const SortMethod sort : sorts) {
    SCOPED_TRACE(name(sort));
    CellTable table(sort);
    expect_table(table, points, {});
    expect_table(table, points, ids(points.size()));
  }
}

int allocations = 0;
/// Ours: what Kokkos keeps for itself on a device is its own matter.
void on_allocate(Kokkos_Profiling_SpaceHandle, const char* name, const void*, const uint64_t) {
  allocations += std::string_view(name).starts_with("drench::") ? 1 : 0;
}

std::vector<Vec3> random_points(std::size_t n, double from, double to, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> axis(from, to);
  std::vector<Vec3> points(n);
  for (Vec3& p : points) p = {axis(random), axis(random), axis(random)};
  return points;
}

}  // namespace

TEST(bucket_sort, no_point_and_one_point) {
  expect_all_sorts({});
  expect_all_sorts({{0.1, 0.2, -0.3}});
}

TEST(bucket_sort, powers_of_two_and_their_neighbours) {
  for (std::size_t power = 2; power <= 16384; power *= 2)
    for (const std::size_t n : {power - 1, power, power + 1}) {
      SCOPED_TRACE(n);
      expect_all_sorts(random_points(n, -1, 1, static_cast<unsigned>(n)));
    }
}

TEST(bucket_sort, passes_over_far_more_than_a_block) { expect_all_sorts(random_points(140000, -3, 3, 12)); }

TEST(bucket_sort, negative_coordinates) { expect_all_sorts(random_points(3000, -7.7, -4.3, 2)); }

TEST(bucket_sort, points_on_cell_faces) {
  std::vector<Vec3> points;
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = -6; k <= 6; ++k) points.push_back({0.125 * k, 0.125 * j, 0.125 * i});
  std::shuffle(points.begin(), points.end(), std::mt19937(3));
  expect_all_sorts(points);
}

TEST(bucket_sort, coincident_points) {
  std::vector<Vec3> points(700, Vec3{0.5, -0.5, 0.25});
  for (const Vec3& p : random_points(50, -1, 1, 4)) points.push_back(p);
  expect_all_sorts(points);
}

TEST(bucket_sort, an_unbounded_domain_is_hashed) {
  std::vector<Vec3> points = random_points(4000, -0.5, 0.5, 5);
  for (const Vec3& p : random_points(3000, -4000, 4000, 6)) points.push_back(p);
  expect_all_sorts(points);
  CellTable table(SortMethod::radix);
  table.build(kokkos_backend::to_device3("points", points), static_cast<Index>(points.size()), edge);
  const Copy copy = copy_of(table.view(), static_cast<Index>(points.size()));
  EXPECT_TRUE(copy.hashed);
  int shared = 0;  // buckets that hold more than one cell
  for (std::size_t b = 0; b + 1 < copy.start.size(); ++b)
    for (Index e = copy.start[b]; e < copy.start[b + 1]; ++e)
      if (copy.coord[std::size_t(e)] != copy.coord[std::size_t(copy.start[b])]) {
        ++shared;
        break;
      }
  EXPECT_GT(shared, 0) << "no bucket is shared: the order by cell was not tried";
}

TEST(bucket_sort, points_that_are_not_finite) {
  std::vector<Vec3> points = random_points(300, 0, 1, 7);
  points.insert(points.begin() + 10, {std::numeric_limits<double>::quiet_NaN(), 0.5, 0.5});
  points.insert(points.begin() + 20, {0.5, std::numeric_limits<double>::infinity(), 0.5});
  expect_all_sorts(points);
}

TEST(bucket_sort, a_table_that_grows_and_shrinks) {
  for (const SortMethod sort : sorts) {
    SCOPED_TRACE(name(sort));
    CellTable table(sort);
    for (const std::size_t n : {100u, 9000u, 0u, 3u, 5000u, 30000u, 29000u})
      expect_table(table, random_points(n, -2, 2, static_cast<unsigned>(n)), ids(n));
  }
}

TEST(bucket_sort, tables_that_are_no_larger_allocate_nothing) {
  const Array<Real3> first = kokkos_backend::to_device3("points", random_points(6000, -1, 1, 13));
  const Array<Real3> second = kokkos_backend::to_device3("points", random_points(6000, -0.9, 0.9, 14));
  for (const SortMethod sort : sorts) {
    CellTable table(sort);
    table.build(first, 6000, edge);
    allocations = 0;
    Kokkos::Tools::Experimental::set_allocate_data_callback(on_allocate);
    for (const Index n : {6000, 5000, 1, 6000}) table.build(second, n, edge);
    EXPECT_EQ(allocations, 0) << name(sort);
    CellTable fresh(sort);
    fresh.build(first, 6000, edge);
    EXPECT_GT(allocations, 3) << "the watch is blind";
    Kokkos::Tools::Experimental::set_allocate_data_callback(nullptr);
  }
}

TEST(bucket_sort, the_order_is_by_id_wherever_a_particle_stands) {
  const std::vector<Vec3> points = random_points(2500, 0, 1.5, 8);
  const std::vector<std::int64_t> id = ids(points.size());
  std::vector<std::size_t> place(points.size());
  std::iota(place.begin(), place.end(), std::size_t{0});
  std::shuffle(place.begin(), place.end(), std::mt19937(9));
  std::vector<Vec3> moved;
  std::vector<std::int64_t> moved_id;
  for (const std::size_t i : place) {
    moved.push_back(points[i]);
    moved_id.push_back(id[i]);
  }
  for (const SortMethod sort : sorts) {
    SCOPED_TRACE(name(sort));
    const auto build = [&](const std::vector<Vec3>& x, const std::vector<std::int64_t>& k) {
      CellTable table(sort);
      table.build(kokkos_backend::to_device3("points", x), static_cast<Index>(x.size()), edge,
                  kokkos_backend::to_device<std::int64_t>("keys", k));
      Copy copy = copy_of(table.view(), static_cast<Index>(x.size()));
      std::vector<std::int64_t> order;
      for (const Index i : copy.item) order.push_back(k[static_cast<std::size_t>(i)]);
      return std::pair(copy.position, order);
    };
    EXPECT_EQ(build(points, id), build(moved, moved_id));
  }
}

TEST(bucket_sort, a_run_has_the_same_bits_with_every_sort) {
  HostState first;
  for (const SortMethod sort : sorts) {
    const auto setup =
        setup_from(with(wet_scene(), "output:", std::string("neighbors: {sort: ") + name(sort) + "}\noutput:"));
    const auto backend = make_kokkos_backend(setup.model);
    Pipeline pipeline(setup.model, *backend, setup.state);
    for (int s = 0; s < 4; ++s) pipeline.step(1.0);
    const HostState end = backend->download();
    if (sort == SortMethod::automatic) {
      first = end;
      EXPECT_NE(end.fluid_position, setup.state.fluid_position);
      continue;
    }
    EXPECT_EQ(end.fluid_position, first.fluid_position) << name(sort);
    EXPECT_EQ(end.fluid_velocity, first.fluid_velocity) << name(sort);
    EXPECT_EQ(end.fluid_mass, first.fluid_mass) << name(sort);
    EXPECT_EQ(end.node_position, first.node_position) << name(sort);
    EXPECT_EQ(end.node_liquid, first.node_liquid) << name(sort);
  }
}

}  // namespace drench::test
