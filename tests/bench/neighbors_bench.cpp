// Times the search for neighbours with every sort (tools/measure/bench_neighbors); prints tables in Markdown. Needs the
// backend and no file, so that the program runs alone on a machine with nothing but a GPU.
// docs/dev/benchmarks/neighbor_search.md describes the columns.

#include <Kokkos_Sort.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/bucket_sort.hpp"
#include "core/kernel.hpp"
#include "core/neighbor_search.hpp"

namespace drench::kokkos_backend {
namespace {

struct Options {
  Index least = 1 << 14, most = 1 << 22;
  int runs = 20;
  bool shuffle = false;
};

struct Method {
  const char* name;
  SortMethod sort;
};
constexpr Method methods[] = {{"counting", SortMethod::counting},
                              {"radix", SortMethod::radix},
                              {"bitonic", SortMethod::bitonic},
                              {"bitonic_naive", SortMethod::bitonic_naive}};
constexpr std::size_t radix = 1, fused = 2, naive = 3, library = 4;  // the last is sort_by_key

/// Medians, ms.
struct Times {
  double keys = 0, sort = 0, table = 0, all = 0;  // `all` without a fence between the parts
};

struct Row {
  Index count = 0;
  Times of[5];
  double list = 0, density = 0, neighbors = 0;
};

/// The paper's Table 7 (GeForce GTX 1080 Ti), ms a frame.
struct PaperRow {
  Index count;
  double thrust, bitonic, claimed;  // neighbour search; "speedup", which is that of the whole frame
};
constexpr PaperRow paper[] = {{200000, 9.8, 1.1, 8.9}, {400000, 23.7, 2.3, 9.0}, {600000, 44.1, 4.5, 9.3}};

struct Particles {
  Array<Real3> position;
  Array<std::int64_t> id;
};

constexpr Real support = 2;

template <class T>
Array<T> upload(const char* label, const std::vector<T>& values) {
  const Array<T> a(std::string(label), values.size());
  const Kokkos::View<const T*, Kokkos::HostSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>> host(values.data(),
                                                                                                values.size());
  Kokkos::deep_copy(a, host);
  return a;
}

Particles make_particles(Index count, bool shuffle) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto moved = [&](const Real3& p, double by) {
    return Real3{p.x + Real(by * unit(random)), p.y + Real(by * unit(random)), p.z + Real(by * unit(random))};
  };
  Index side = 1;
  while (std::int64_t{side} * side * side < count) ++side;
  std::vector<Real3> x;
  x.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    const Index column = i % side, row = i / side % side, layer = i / side / side;
    x.push_back(moved({Real(column), Real(row), Real(layer)}, 0.25));
  }
  CellTable cells;
  cells.build(upload("drench::bench::lattice", x), count, support);
  const auto item = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), cells.view().item);
  std::vector<Index> order(item.data(), item.data() + count);
  if (shuffle) std::shuffle(order.begin(), order.end(), random);
  std::vector<Real3> position;
  std::vector<std::int64_t> id;
  for (const Index i : order) {
    position.push_back(moved(x[static_cast<std::size_t>(i)], 0.1));
    id.push_back(i);
  }
  return {upload("drench::bench::position", position), upload("drench::bench::id", id)};
}

template <class Body>
double timed(const Body& body) {
  Kokkos::fence();
  const Kokkos::Timer timer;
  body();
  Kokkos::fence();
  return timer.seconds() * 1e3;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 != 0 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

constexpr int warm_up = 3;

Times time_sort(CellTable& cells, const Particles& p, Index count, int runs) {
  std::vector<double> keys, sort, table, all;
  for (int run = -warm_up; run < runs; ++run) {
    const double a = timed([&] { cells.make_keys(p.position, count, support); });
    const double b = timed([&] { cells.sort(); });
    const double c = timed([&] { cells.make_table(p.position, p.id); });
    const double d = timed([&] { cells.build(p.position, count, support, p.id); });
    if (run < 0) continue;
    keys.push_back(a);
    sort.push_back(b);
    table.push_back(c);
    all.push_back(d);
  }
  return {median(keys), median(sort), median(table), median(all)};
}

void fill_pairs(const CellTableView& t, const Array<Real3>& x, Index count, const Array<std::uint32_t>& key,
                const Array<Index>& item) {
  parallel(
      "drench::bench::keys", count, KOKKOS_LAMBDA(const Index i) {
        key(i) = static_cast<std::uint32_t>(bucket_of_point(t, x(i)));
        item(i) = i;
      });
}

/// Kokkos::Experimental::sort_by_key as it comes: on CUDA Thrust's, which allocates in every call.
double time_library_sort(const CellTableView& table, const Particles& p, Index count, int runs) {
  const Array<std::uint32_t> key("drench::bench::key", static_cast<std::size_t>(count));
  const Array<Index> item("drench::bench::item", static_cast<std::size_t>(count));
  std::vector<double> sort;
  for (int run = -warm_up; run < runs; ++run) {
    fill_pairs(table, p.position, count, key, item);
    const double ms = timed([&] { Kokkos::Experimental::sort_by_key(ExecSpace(), key, item); });
    if (run >= 0) sort.push_back(ms);
  }
  return median(sort);
}

/// Entries in which two tables differ.
Index difference(const CellTableView& a, const CellTableView& b, Index count) {
  if (a.buckets != b.buckets) return count;
  Index items = 0, starts = 0;
  Kokkos::parallel_reduce(
      "drench::bench::items", Range(0, count),
      KOKKOS_LAMBDA(const Index e, Index& sum) {
        sum += a.item(e) != b.item(e) || (a.hashed != 0 && !(a.coord(e) == b.coord(e))) || a.point(e).x != b.point(e).x
                   ? 1
                   : 0;
      },
      items);
  Kokkos::parallel_reduce(
      "drench::bench::starts", Range(0, a.buckets + 1),
      KOKKOS_LAMBDA(const Index k, Index& sum) { sum += a.start(k) != b.start(k) ? 1 : 0; }, starts);
  return items + starts;
}

void sum_density(const NeighborList& neighbors, const Array<Real3>& x, const Kernel& kernel,
                 const Array<Real>& density) {
  const Neighbors list(neighbors);
  parallel(
      "drench::bench::density", neighbors.rows, KOKKOS_LAMBDA(const Index i) {
        const Real3 xi = x(i);
        Real sum = kernel.value(0);
        const NeighborRow near = list.row(i);
        for (Index k = 0; k < near.count; ++k) sum += kernel.value(norm(xi - x(near(k))));
        density(i) = sum;
      });
}

double mean_count(const NeighborList& neighbors) {
  const Entries<const Index> count = neighbors.count;
  std::int64_t all = 0;
  Kokkos::parallel_reduce(
      "drench::bench::neighbors", Range(0, neighbors.rows),
      KOKKOS_LAMBDA(const Index i, std::int64_t& sum) { sum += count(i); }, all);
  return static_cast<double>(all) / neighbors.rows;
}

Row measure(Index count, const Options& options) {
  Row row;
  row.count = count;
  const Particles p = make_particles(count, options.shuffle);
  CellTable counting(SortMethod::counting);
  row.of[0] = time_sort(counting, p, count, options.runs);
  for (std::size_t m = 1; m < std::size(methods); ++m) {
    CellTable cells(methods[m].sort);
    row.of[m] = time_sort(cells, p, count, options.runs);
    if (const Index wrong = difference(counting.view(), cells.view(), count); wrong != 0) {
      std::fprintf(stderr, "%s: %d entries differ from the counting sort's table at N = %d\n", methods[m].name, wrong,
                   count);
      std::exit(1);
    }
  }
  Times& by_library = row.of[library];
  by_library = row.of[radix];
  by_library.sort = time_library_sort(counting.view(), p, count, options.runs);
  by_library.all = row.of[radix].all - row.of[radix].sort + by_library.sort;

  NeighborList neighbors;
  const Kernel kernel(KernelKind::cubic, support);
  const Array<Real> density("drench::bench::density", static_cast<std::size_t>(count));
  std::vector<double> list, sum;
  for (int run = -warm_up; run < options.runs; ++run) {
    const double a = timed([&] {
      build_neighbor_list({&neighbors, &p.position, count, counting.view(), true}, support);
    });
    const double b = timed([&] { sum_density(neighbors, p.position, kernel, density); });
    if (run < 0) continue;
    list.push_back(a);
    sum.push_back(b);
  }
  row.list = median(list);
  row.density = median(sum);
  row.neighbors = mean_count(neighbors);
  return row;
}

std::string grouped(Index n) {
  std::string text = std::to_string(n);
  for (int at = static_cast<int>(text.size()) - 3; at > 0; at -= 3) text.insert(static_cast<std::size_t>(at), ",");
  return text;
}

const char* library_name() { return std::strcmp(ExecSpace::name(), "Cuda") == 0 ? "Thrust" : "Kokkos::sort_by_key"; }

void print(const Row& row) {
  for (std::size_t m = 0; m <= std::size(methods); ++m) {
    const Times& t = row.of[m];
    std::printf("| %s | %s | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f |\n", grouped(row.count).c_str(),
                m < std::size(methods) ? methods[m].name : library_name(), t.keys, t.sort, t.table, t.all, row.list,
                row.density);
  }
  for (const PaperRow& r : paper)
    if (r.count == row.count) {
      std::printf("| %s | *paper: Thrust* | | | | *%.1f* | | |\n", grouped(row.count).c_str(), r.thrust);
      std::printf("| %s | *paper: bitonic* | | | | *%.1f* | | |\n", grouped(row.count).c_str(), r.bitonic);
    }
  std::fflush(stdout);
}

const char* verdict(bool holds) { return holds ? "holds" : "**does not hold**"; }

void print_claims(const std::vector<Row>& rows) {
  std::printf("\nThe paper's claims, here (%s stands for the paper's Thrust):\n", library_name());
  std::printf("- Bitonic sorts 9 to 10 times as fast as Thrust (the sort alone):\n");
  for (const Row& r : rows) {
    const double by_naive = r.of[library].sort / r.of[naive].sort, by_fused = r.of[library].sort / r.of[fused].sort;
    std::printf("  - %s: as the paper prints it %.2f times (%s), with fused passes %.2f times (%s);\n",
                grouped(r.count).c_str(), by_naive, verdict(by_naive >= 9), by_fused, verdict(by_fused >= 9));
  }
  bool any = false;
  for (const Row& r : rows)
    for (const PaperRow& p : paper) {
      if (p.count != r.count) continue;
      if (!any) std::printf("- Table 7, neighbour search (keys, sort and table):\n");
      any = true;
      const double by_naive = r.of[library].all / r.of[naive].all, by_fused = r.of[library].all / r.of[fused].all;
      const double theirs = p.thrust / p.bitonic;
      std::printf(
          "  - %s: the paper %.1f to %.1f ms, %.1f times (whole frame %.1f times); here %.2f times as printed (%s), "
          "%.2f "
          "times fused (%s);\n",
          grouped(r.count).c_str(), p.thrust, p.bitonic, theirs, p.claimed, by_naive, verdict(by_naive >= theirs),
          by_fused, verdict(by_fused >= theirs));
    }
  const Row &a = rows.front(), &b = rows.back();
  const auto growth = [&](std::size_t m) { return b.of[m].sort / a.of[m].sort; };
  if (rows.size() > 1)
    std::printf(
        "- Figure 9, bitonic's time changes little with N where Thrust's rises: from %s to %s particles %s takes %.1f "
        "times as long, bitonic as printed %.1f times (%s), fused %.1f times (%s);\n",
        grouped(a.count).c_str(), grouped(b.count).c_str(), library_name(), growth(library), growth(naive),
        verdict(growth(naive) < growth(library)), growth(fused), verdict(growth(fused) < growth(library)));
  std::printf(
      "- Figure 10, the density is quicker over a table that bitonic sort made: %s, the tables are equal in every "
      "bit;\n"
      "- Figure 11, densities differ a little with the sort: %s, for the same reason.\n",
      verdict(false), verdict(false));
  std::printf("\nFastest of drench's sorts, keys to table:");
  for (const Row& r : rows) {
    std::size_t best = 0;
    for (std::size_t m = 1; m < std::size(methods); ++m)
      if (r.of[m].all < r.of[best].all) best = m;
    std::printf(" %s at %s%s", methods[best].name, grouped(r.count).c_str(), &r == &rows.back() ? "." : ",");
  }
  for (const Method& m : methods)
    if (m.sort == fastest_sort) std::printf(" `sort: auto` takes %s.\n", m.name);
}

std::string device_name() {
#ifdef KOKKOS_ENABLE_CUDA
  return ExecSpace().cuda_device_prop().name;
#else
  return std::to_string(ExecSpace().concurrency()) + " threads of the host";
#endif
}

void run(const Options& options) {
  std::vector<Index> sizes;
  for (Index n = 1 << 14; n <= 1 << 22; n *= 2) sizes.push_back(n);
  for (const PaperRow& r : paper) sizes.push_back(r.count);
  sizes.push_back(800120);  // the paper's largest scene
  std::sort(sizes.begin(), sizes.end());
  std::erase_if(sizes, [&](Index n) { return n < options.least || n > options.most; });
  if (sizes.empty()) sizes.push_back(options.most);

  std::printf("%s, %s, %s; particles in %s; median of %d runs after %d, ms. `all`: keys, sort and table in one go.\n\n",
              ExecSpace::name(), device_name().c_str(), sizeof(Real) == 8 ? "double" : "float",
              options.shuffle ? "no order" : "the order of their cells a step ago", options.runs, warm_up);
  std::printf("| N | sort | keys | sort | table | all | list | density |\n|---|---|---|---|---|---|---|---|\n");
  std::vector<Row> rows;
  for (const Index n : sizes) {
    rows.push_back(measure(n, options));
    print(rows.back());
  }
  std::printf(
      "\n%.1f neighbours at the largest N. List and density do not depend on the sort and were timed once for each N. "
      "%s: the "
      "sort alone is its own, keys and table are those of radix. Rows of the paper: Table 7, GeForce GTX 1080 Ti, its "
      "\"neighbor search\".\n",
      rows.back().neighbors, library_name());
  print_claims(rows);
}

[[noreturn]] void usage() {
  std::fprintf(stderr, "drench_bench_neighbors [--min N] [--max N] [--runs N] [--shuffle]\n");
  std::exit(2);
}

Options read(int argc, char** argv) {
  Options options;
  for (int a = 1; a < argc; ++a) {
    const std::string word = argv[a];
    if (word == "--shuffle") {
      options.shuffle = true;
      continue;
    }
    const long value = a + 1 < argc ? std::strtol(argv[++a], nullptr, 10) : 0;
    if (value < 1 || value > 1 << 28) usage();
    if (word == "--min")
      options.least = static_cast<Index>(value);
    else if (word == "--max")
      options.most = static_cast<Index>(value);
    else if (word == "--runs")
      options.runs = static_cast<int>(value);
    else
      usage();
  }
  return options;
}

}  // namespace
}  // namespace drench::kokkos_backend

int main(int argc, char** argv) {
  const auto options = drench::kokkos_backend::read(argc, argv);
  const Kokkos::ScopeGuard kokkos(Kokkos::InitializationSettings().set_disable_warnings(true));
  drench::kokkos_backend::HostLoops::most = drench::kokkos_backend::HostLoops::all =
      drench::kokkos_backend::ExecSpace().concurrency();
  drench::kokkos_backend::run(options);
}
