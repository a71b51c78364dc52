#pragma once
// Cell table: cells of edge h over the occupied bounds, particles ordered by (cell, key), by one of the sorts in
// bucket_sort.hpp, which all make the same table. Dense while the bounds hold few cells; otherwise hashed by bricks of
// cells (Brick), and cell coordinates are compared, so that two cells that share a bucket are never mixed up.

#include <memory>
#include <type_traits>

#include "core/ranks.hpp"
#include "core/sizing.hpp"
#include "core/types.hpp"
#include "scene/scene.hpp"

namespace drench::kokkos_backend {

struct CellCoord {
  int x, y, z;
  KOKKOS_INLINE_FUNCTION bool operator==(const CellCoord& o) const { return x == o.x && y == o.y && z == o.z; }
};

/// Cells side by side in x, [x, end] at y, z; of a hashed table all in one brick.
struct CellRun {
  int x, end, y, z;
  KOKKOS_INLINE_FUNCTION bool holds(const CellCoord& c) const { return c.y == y && c.z == z && c.x >= x && c.x <= end; }
};

/// Cells of a hashed table that have buckets one after the other, x first: near cells lie near in memory, and a search
/// has fewer buckets to look at. Long in x, for a search reads runs along x.
struct Brick {
  static constexpr int x_bits = 4, y_bits = 1, z_bits = 1, bits = x_bits + y_bits + z_bits, cells = 1 << bits;

  /// A cell's number within its brick.
  KOKKOS_INLINE_FUNCTION static Index within(const CellCoord& c) {
    return ((c.z & ((1 << z_bits) - 1)) << (y_bits + x_bits)) | ((c.y & ((1 << y_bits) - 1)) << x_bits) |
           (c.x & ((1 << x_bits) - 1));
  }
  /// The brick of a cell, also of negative ones.
  KOKKOS_INLINE_FUNCTION static CellCoord of(const CellCoord& c) {
    return {c.x >> x_bits, c.y >> y_bits, c.z >> z_bits};
  }
  /// The last x of the brick that x lies in.
  KOKKOS_INLINE_FUNCTION static int last_x(int x) { return x | ((1 << x_bits) - 1); }
};

/// Positions (m) of a table's entries, a copy that a search reads in order, and `spare` more. A CPU compares a register
/// of coordinates at once, a GPU thread loads a point at once.
struct PointLanes {
  static constexpr Index spare = 16;
  Array<Real> x, y, z;
  void allocate(Index n) {
    for (Array<Real>* a : {&x, &y, &z}) *a = Array<Real>("drench::cell_point", n + spare);
  }
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index e) const { return {x(e), y(e), z(e)}; }
  KOKKOS_INLINE_FUNCTION void set(Index e, const Real3& p) const {
    x(e) = p.x;
    y(e) = p.y;
    z(e) = p.z;
  }
};
struct PackedPoints {
  Array<Real4> point;
  void allocate(Index n) { point = Array<Real4>(Kokkos::ViewAllocateWithoutInitializing("drench::cell_point"), n); }
  KOKKOS_INLINE_FUNCTION Real3 operator()(Index e) const {
    const Real4 p = point(e);
    return p.xyz();
  }
  KOKKOS_INLINE_FUNCTION void set(Index e, const Real3& p) const { point(e) = {p, Real(0)}; }
};
using CellPoints = std::conditional_t<on_host, PointLanes, PackedPoints>;

/// Which cell a point lies in, and which bucket a cell.
struct CellGeometry {
  Real3 origin;
  Real inverse_edge = 1;
  CellCoord dims{0, 0, 0};
  Index buckets = 0;
  int hashed = 0;

  KOKKOS_INLINE_FUNCTION static int cell_axis(Real x, Real origin, Real inverse_edge) {
    const Real c = Kokkos::floor((x - origin) * inverse_edge);
    if (!(c > Real(-1e6))) return -1000000;  // also NaN
    return c < Real(1e6) ? static_cast<int>(c) : 1000000;
  }
  KOKKOS_INLINE_FUNCTION CellCoord cell_of(const Real3& p) const {
    return {cell_axis(p.x, origin.x, inverse_edge), cell_axis(p.y, origin.y, inverse_edge),
            cell_axis(p.z, origin.z, inverse_edge)};
  }
  /// The bucket of a cell, or −1 when the cell is outside the dense bounds.
  KOKKOS_INLINE_FUNCTION Index bucket_of(const CellCoord& c) const {
    if (!hashed) {
      if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= dims.x || c.y >= dims.y || c.z >= dims.z) return -1;
      return (c.z * dims.y + c.y) * dims.x + c.x;
    }
    const CellCoord b = Brick::of(c);
    std::uint32_t h = static_cast<std::uint32_t>(b.x) * 73856093u ^ static_cast<std::uint32_t>(b.y) * 19349663u ^
                      static_cast<std::uint32_t>(b.z) * 83492791u;
    h ^= h >> 15;
    return static_cast<Index>((h << Brick::bits) & static_cast<std::uint32_t>(buckets - 1)) | Brick::within(c);
  }
  /// [lo, hi] without the cells beyond the dense bounds.
  KOKKOS_INLINE_FUNCTION void clip(CellCoord& lo, CellCoord& hi) const {
    if (hashed) return;
    lo = {lo.x < 0 ? 0 : lo.x, lo.y < 0 ? 0 : lo.y, lo.z < 0 ? 0 : lo.z};
    hi = {hi.x >= dims.x ? dims.x - 1 : hi.x, hi.y >= dims.y ? dims.y - 1 : hi.y, hi.z >= dims.z ? dims.z - 1 : hi.z};
  }
};

/// What kernels capture.
struct CellTableView : CellGeometry {
  Array<Index> start;      // buckets + 1
  Array<Index> item;       // particle indices, ordered by bucket, then cell, then key
  Array<CellCoord> coord;  // of each entry of `item`, in a hashed table
  CellPoints point;        // of each entry of `item`

  /// Calls visit(item) for every particle in the cells [lo, hi] (inclusive), in a fixed order.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void for_cells(const CellCoord& lo, const CellCoord& hi, Visit&& visit) const {
    if (buckets == 0) return;
    CellCoord a = lo, b = hi;
    clip(a, b);
    for_runs(a, b, [&](const Index first, const Index last, const CellRun& run) {
      for (Index e = first; e < last; ++e)
        if (!hashed || run.holds(coord(e))) visit(item(e));
    });
  }
  /// Calls visit(first, last, run) for the runs of the cells [lo, hi], which must be within the dense bounds, in the
  /// order of z, y, x, with their entries [first, last); in a hashed table there may be those of other cells among
  /// them.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void for_runs(const CellCoord& lo, const CellCoord& hi, Visit&& visit) const {
    for (int z = lo.z; z <= hi.z; ++z)
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int x = lo.x, end; x <= hi.x; x = end + 1) {
          end = hashed && Brick::last_x(x) < hi.x ? Brick::last_x(x) : hi.x;
          const Index k = bucket_of({x, y, z});
          visit(start(k), start(k + (end - x) + 1), CellRun{x, end, y, z});
        }
      }
  }
  /// Calls visit(item) for every particle in the 27 cells around a point.
  template <class Visit>
  KOKKOS_INLINE_FUNCTION void for_near(const Real3& p, Visit&& visit) const {
    const CellCoord c = cell_of(p);
    for_cells({c.x - 1, c.y - 1, c.z - 1}, {c.x + 1, c.y + 1, c.z + 1}, visit);
  }
};

/// The box around points, m; what is not finite is left out. Empty: min > max.
struct PointBounds {
  Real min_x = 0, min_y = 0, min_z = 0, max_x = 0, max_y = 0, max_z = 0;

  /// Around nothing: to be grown.
  KOKKOS_INLINE_FUNCTION void clear() {
    min_x = min_y = min_z = Kokkos::Experimental::finite_max_v<Real>;
    max_x = max_y = max_z = -Kokkos::Experimental::finite_max_v<Real>;
  }
  KOKKOS_INLINE_FUNCTION void add(const Real3& p) {
    if (Kokkos::abs(p.x) + Kokkos::abs(p.y) + Kokkos::abs(p.z) < Real(1e12))
      add(PointBounds{p.x, p.y, p.z, p.x, p.y, p.z});
  }
  KOKKOS_INLINE_FUNCTION void add(const PointBounds& o) {
    min_x = o.min_x < min_x ? o.min_x : min_x;
    min_y = o.min_y < min_y ? o.min_y : min_y;
    min_z = o.min_z < min_z ? o.min_z : min_z;
    max_x = o.max_x > max_x ? o.max_x : max_x;
    max_y = o.max_y > max_y ? o.max_y : max_y;
    max_z = o.max_z > max_z ? o.max_z : max_z;
  }
};
/// Bounds as maxima, of which all ranks' are found in one message. Exact: a double holds each Real.
struct BoundsOverRanks {
  double most[6];
  explicit BoundsOverRanks(const PointBounds& b)
      : most{-double(b.min_x), -double(b.min_y), -double(b.min_z), double(b.max_x), double(b.max_y), double(b.max_z)} {}
  void visit(OverRanks& all) {
    for (double& m : most) all.maximum(m);
  }
  PointBounds bounds() const {
    return {Real(-most[0]), Real(-most[1]), Real(-most[2]), Real(most[3]), Real(most[4]), Real(most[5])};
  }
};
/// Around the first `count` points; the host waits.
PointBounds find_bounds(const Array<Real3>& points, Index count);
/// Where a kernel leaves bounds for the host, which has to wait for it.
using HostBounds = Kokkos::View<PointBounds, Kokkos::SharedHostPinnedSpace>;

class BucketSort;

class CellTable {
 public:
  CellTable() = default;
  explicit CellTable(SortMethod sort) : method_(sort) {}
  /// Sorts `count` points into cells of edge `edge` (m). Within a cell the order is by `key` (empty: by index).
  /// `bounds`, if given, are the points', and the host has waited for them: else this waits for its own.
  /// `all`, if given: of how many points these are a part, whose order in memory has to be theirs.
  void build(const Array<Real3>& points, Index count, Real edge, const Array<std::int64_t>& key = {},
             const PointBounds* bounds = nullptr, std::int64_t all = 0);
  const CellTableView& view() const { return view_; }

  // The parts of `build`, one after the other, for measurements.
  void make_keys(const Array<Real3>& points, Index count, Real edge, const PointBounds* bounds = nullptr,
                 std::int64_t all = 0);
  void sort();
  void make_table(const Array<Real3>& points, const Array<std::int64_t>& key);

 private:
  SortMethod method_ = SortMethod::automatic;
  std::shared_ptr<BucketSort> sort_;  // none before the first points
  CellTableView view_;
  Array<Index> ordered_;  // `item`, in order within the buckets, before they are exchanged (GPU)
  HostBounds bounds_;
  Index count_ = 0, capacity_ = 0, bucket_capacity_ = 0;
};

/// Of a table of so many points in so many cells; no cells: a hashed table.
double cell_table_bytes(double points, double cells, const Sizing& s);

}  // namespace drench::kokkos_backend
