// Compact pairs of the liquid (core/liquid_pairs.hpp): what is written is read again, near and far.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/host_copy.hpp"
#include "core/liquid_pairs.hpp"
#include "core/neighbor_search.hpp"

namespace drench::kokkos_backend {
namespace {

struct Row {
  Index number;
  std::vector<Index> neighbors;
};

/// The row as kernels read it, `filled_up` with what fills up its last group.
std::vector<Index> written_and_read(const Row& row, bool far, bool filled_up) {
  const auto groups = (row.neighbors.size() + 3) / 4;
  std::vector<FarFour> room(groups * rows_per_bundle + 1);
  Index* const entry = room.front().index;
  const std::int64_t start = far ? ~std::int64_t{0} : 0;
  CompactRowWriter writer(entry, start, row.number);
  for (const Index j : row.neighbors) writer.put(j);
  writer.finish();
  EXPECT_EQ(writer.count, static_cast<Index>(row.neighbors.size()));
  const CompactRow read(entry, start, row.number, writer.count);
  for (Index k = 0; k < writer.count; ++k) EXPECT_EQ(read(k), row.neighbors[static_cast<std::size_t>(k)]);
  std::vector<Index> seen;
  if (filled_up)
    read.for_each_filled_up([&](std::uint32_t k, Index origin) { seen.push_back(static_cast<Index>(k) + origin); });
  else
    read.for_each([&](Index j) { seen.push_back(j); });
  return seen;
}

/// Points in the order of their cells.
std::vector<Vec3> in_order_of_cells(const std::vector<Vec3>& points, Real support) {
  const auto n = static_cast<Index>(points.size());
  CellTable table;
  table.build(to_device3("points", points), n, support);
  const Entries<const Index> item = table.view().item;
  Array<Index> order("order", points.size());
  parallel(
      "test::order", n, KOKKOS_LAMBDA(const Index e) { order(e) = item(e); });
  const auto on_host = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), order);
  std::vector<Vec3> sorted;
  for (Index e = 0; e < n; ++e) sorted.push_back(points[static_cast<std::size_t>(on_host(e))]);
  return sorted;
}

std::vector<std::vector<Index>> rows_of(const std::vector<Vec3>& points, Real support, bool in_order, bool compact) {
  const auto n = static_cast<Index>(points.size());
  const Array<Real3> x = to_device3("points", points);
  CellTable table;
  table.build(x, n, support);
  NeighborList list;
  ListRequest request{&list, &x, n, table.view(), true};
  request.in_order = in_order;
  request.compact = compact;
  build_neighbor_list(request, support);
  return rows_on_host(list);
}

}  // namespace

TEST(compact_pairs, rows_of_any_length_are_read_as_they_were_written) {
  for (const Index number : {0, 5, 70'000})
    for (const bool far : {false, true}) {
      Row row{number, {}};
      for (int length = 0; length < 10; ++length) {
        EXPECT_EQ(written_and_read(row, far, false), row.neighbors);
        std::vector<Index> filled_up = row.neighbors;
        while (filled_up.size() % 4 != 0) filled_up.push_back(number);
        EXPECT_EQ(written_and_read(row, far, true), filled_up);
        const Index base = CompactRow::base(number);
        row.neighbors.push_back(far ? 3'000'000 + length : base + (length % 2 == 0 ? length : 0xffff - length));
      }
    }
}

/// A layer of cells has more than 32,768 points, so that some bundles reach farther than 16 bits and some do not;
/// sorted points and those in any order.
TEST(compact_pairs, near_and_far_bundles_have_the_neighbours_of_a_plain_list) {
  constexpr auto support = Real(0.02);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> axis(0, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < 90'000; ++i) points.push_back({axis(random), axis(random), 0.05 * axis(random)});
  const std::vector<Vec3> sorted = in_order_of_cells(points, support);
  EXPECT_EQ(rows_of(sorted, support, true, compact_pairs), rows_of(sorted, support, true, false));
  EXPECT_EQ(rows_of(points, support, false, compact_pairs), rows_of(points, support, false, false));
}

}  // namespace drench::kokkos_backend
