// Bodies that change their shape: distances to their surface at the end of a step.

#include "bodies/contact.hpp"
#include "bodies/deforming_body.hpp"
#include "state/deforming_body.hpp"

namespace drench::kokkos_backend {
namespace {

KOKKOS_INLINE_FUNCTION Real least(Real a, Real b, Real c) { return smaller(a, smaller(b, c)); }
KOKKOS_INLINE_FUNCTION Real most(Real a, Real b, Real c) { return larger(a, larger(b, c)); }

/// Which lattice points are block b, and how they lie in memory.
struct Lattice {
  Index points[3], blocks[3];
  Real step;  // m

  explicit Lattice(const DeformingBody& d)
      : points{d.lattice[0], d.lattice[1], d.lattice[2]}, blocks{d.blocks[0], d.blocks[1], d.blocks[2]}, step(d.step) {}
  KOKKOS_INLINE_FUNCTION Index count() const { return points[0] * points[1] * points[2]; }
  KOKKOS_INLINE_FUNCTION Index block_of(Index i, Index j, Index k) const {
    constexpr Index edge = DeformingBody::block_edge;
    return (k / edge * blocks[1] + j / edge) * blocks[0] + i / edge;
  }
};

void move_points(DeformingBody& d, const StepInfo& info) {
  const PointsOfStep points = points_of_step(d, info.time, info.dt);
  const Vec3 corner = lattice_origin(d.body, info.time + info.dt);
  const Double3 origin{corner[0], corner[1], corner[2]};
  const double rate = 1 / info.dt;
  allocate_zeros(d.position, "drench::deforming_position", static_cast<std::size_t>(d.points));
  allocate_zeros(d.velocity, "drench::deforming_velocity", static_cast<std::size_t>(d.points));
  const Entries<Real3> x = d.position, v = d.velocity;
  parallel(
      "drench::deforming_body::points", d.points, KOKKOS_LAMBDA(const Index n) {
        const Double3 end = points.end(n);
        x(n) = narrow(minus(end, origin));
        v(n) = narrow(times(rate, minus(end, points.begin(n))));
      });
}

/// Normals of the triangles, and of the points, weighted by angles (Bærentzen and Aanæs 2005).
void turn_normals(DeformingBody& d) {
  allocate_zeros(d.face_normal, "drench::deforming_face_normal", static_cast<std::size_t>(d.triangles));
  allocate_zeros(d.point_normal, "drench::deforming_point_normal", static_cast<std::size_t>(d.points));
  allocate_zeros(d.ball, "drench::deforming_ball", static_cast<std::size_t>(d.triangles));
  const Entries<const Index> corner = std::as_const(d).corner, start = std::as_const(d).point_start,
                             item = std::as_const(d).item;
  const Entries<const Real3> x = std::as_const(d).position;
  const Entries<Real3> face = d.face_normal, normal = d.point_normal;
  const Entries<Real4> ball = d.ball;
  parallel(
      "drench::deforming_body::faces", d.triangles, KOKKOS_LAMBDA(const Index t) {
        const Real3 a = x(corner(3 * t)), b = x(corner(3 * t + 1)), c = x(corner(3 * t + 2));
        const Real3 across = cross(b - a, c - a), middle = Real(1.0 / 3) * (a + b + c);
        const Real length = norm(across);
        face(t) = length > 0 ? (1 / length) * across : Real3{};
        ball(t) = {middle, most(norm(a - middle), norm(b - middle), norm(c - middle))};
      });
  parallel(
      "drench::deforming_body::point_normals", d.points, KOKKOS_LAMBDA(const Index n) {
        Real3 sum;
        for (Index e = start(n); e < start(n + 1); ++e) {
          const Index t = item(e) / 4, c = item(e) % 4;
          const Real3 u = x(corner(3 * t + (c + 1) % 3)) - x(n), v = x(corner(3 * t + (c + 2) % 3)) - x(n);
          const Real lengths = norm(u) * norm(v);
          if (!(lengths > 0)) continue;
          const Real cosine = dot(u, v) / lengths;
          sum += Kokkos::acos(cosine > 1 ? Real(1) : cosine < -1 ? Real(-1) : cosine) * face(t);
        }
        normal(n) = sum;
      });
}

enum class Pass { bound, count, write };

/// Which triangles may be the nearest of a point of a block: those no farther from its centre than block_bound and
/// twice the way to its corners, within the band. Passes: the bounds, the numbers of triangles, and the triangles
/// themselves.
struct NearBlocks {
  Pass pass;
  Lattice lattice;
  Real band;
  Entries<const Index> corner, start;
  Entries<const Real3> x, face;
  Entries<const Real4> ball;
  Entries<Real> bound;
  Entries<Index> count, entry;

  KOKKOS_INLINE_FUNCTION void range_of(Real lo, Real hi, int axis, Index& first, Index& last) const {
    constexpr Index edge = DeformingBody::block_edge;
    const Index from = static_cast<Index>(larger(Kokkos::ceil((lo - band) / lattice.step), Real(0))),
                to = static_cast<Index>(larger(Kokkos::floor((hi + band) / lattice.step), Real(0)));
    first = from / edge;
    last = (to < lattice.points[axis] ? to : lattice.points[axis] - 1) / edge;
  }
  /// Bounds of the distance of p to a triangle; the distance itself where the triangle is larger than blocks.
  KOKKOS_INLINE_FUNCTION void distances(const Real3 (&at)[3], const Real4& around, const Real3& p, Real& low,
                                        Real& high) const {
    if (around.w > 2 * lattice.step) {
      const NearestPoint near = nearest_point(at[0], at[1], at[2], p);
      low = high = norm(p - (near.weight[0] * at[0] + near.weight[1] * at[1] + near.weight[2] * at[2]));
      return;
    }
    high = norm(p - around.xyz());
    low = high - around.w;
  }
  KOKKOS_INLINE_FUNCTION void visit(Index t, Index block, Real low, Real high, Real half) const {
    const Real reach = band + half;
    if (low > reach) return;
    if (pass == Pass::bound) {
      Kokkos::atomic_min(&bound(block), high);
      return;
    }
    if (low > bound(block) + 2 * half) return;
    const Index place = Kokkos::atomic_fetch_add(&count(block), 1);
    if (pass == Pass::write) entry(start(block) + place) = t;
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index t) const {
    constexpr Index edge = DeformingBody::block_edge;
    if (!(dot(face(t), face(t)) > 0)) return;  // its edges are those of others
    const Real3 at[3] = {x(corner(3 * t)), x(corner(3 * t + 1)), x(corner(3 * t + 2))};
    const Real4 around = ball(t);
    Index lo[3], hi[3];
    range_of(least(at[0].x, at[1].x, at[2].x), most(at[0].x, at[1].x, at[2].x), 0, lo[0], hi[0]);
    range_of(least(at[0].y, at[1].y, at[2].y), most(at[0].y, at[1].y, at[2].y), 1, lo[1], hi[1]);
    range_of(least(at[0].z, at[1].z, at[2].z), most(at[0].z, at[1].z, at[2].z), 2, lo[2], hi[2]);
    // A little farther than a block's corners are from its centre, so that rounding decides nothing.
    const Real middle = Real(0.5) * (edge - 1), half = Real(1.7321 * 1.001) * middle * lattice.step;
    for (Index k = lo[2]; k <= hi[2]; ++k)
      for (Index j = lo[1]; j <= hi[1]; ++j)
        for (Index i = lo[0]; i <= hi[0]; ++i) {
          Real low, high;
          distances(at, around, lattice.step * Real3{edge * i + middle, edge * j + middle, edge * k + middle}, low,
                    high);
          visit(t, (k * lattice.blocks[1] + j) * lattice.blocks[0] + i, low, high, half);
        }
  }
};

/// block_start and near_triangle. The order of a block's triangles is not determined; nothing depends on it.
void list_triangles(DeformingBody& d) {
  const Index blocks = d.blocks[0] * d.blocks[1] * d.blocks[2];
  allocate_zeros(d.block_bound, "drench::deforming_block_bound", static_cast<std::size_t>(blocks));
  allocate_zeros(d.block_count, "drench::deforming_block_count", static_cast<std::size_t>(blocks));
  allocate_zeros(d.block_start, "drench::deforming_block_start", static_cast<std::size_t>(blocks) + 1);
  const Entries<Index> count = d.block_count, start = d.block_start;
  const Entries<Real> bound = d.block_bound;
  parallel(
      "drench::deforming_body::reset", blocks, KOKKOS_LAMBDA(const Index b) {
        count(b) = 0;
        bound(b) = far_away;
      });
  NearBlocks near{.pass = Pass::bound,
                  .lattice = Lattice(d),
                  .band = d.band,
                  .corner = std::as_const(d).corner,
                  .start = std::as_const(d).block_start,
                  .x = std::as_const(d).position,
                  .face = std::as_const(d).face_normal,
                  .ball = std::as_const(d).ball,
                  .bound = d.block_bound,
                  .count = d.block_count,
                  .entry = {}};
  parallel("drench::deforming_body::bound", d.triangles, near);
  near.pass = Pass::count;
  parallel("drench::deforming_body::count", d.triangles, near);
  Index total = 0;
  Kokkos::parallel_scan(
      "drench::deforming_body::start", range(blocks + 1),
      KOKKOS_LAMBDA(const Index b, Index& sum, const bool final) {
        const Index own = b < blocks ? count(b) : 0;
        if (final) {
          start(b) = sum;
          if (b < blocks) count(b) = 0;
        }
        sum += own;
      },
      total);
  make_ample_room(d.near_triangle, "drench::deforming_near_triangle", static_cast<std::size_t>(total));
  near.pass = Pass::write;
  near.entry = d.near_triangle;
  parallel("drench::deforming_body::list", d.triangles, near);
}

/// The nearest triangle of a lattice point, and where it is nearest.
struct Nearest {
  Index triangle = -1;
  Real square = 0;  // m²
  NearestPoint at{};
};

struct Distances {
  Lattice lattice;
  Real band;
  Entries<const Index> start, entry, corner, neighbor;
  Entries<const Real3> x, face, normal;
  Entries<const Real4> ball;
  Entries<Real> distance;
  Entries<Index> nearest;

  explicit Distances(DeformingBody& d)
      : lattice(d),
        band(d.band),
        start(std::as_const(d).block_start),
        entry(std::as_const(d).near_triangle),
        corner(std::as_const(d).corner),
        neighbor(std::as_const(d).neighbor),
        x(std::as_const(d).position),
        face(std::as_const(d).face_normal),
        normal(std::as_const(d).point_normal),
        ball(std::as_const(d).ball),
        distance(d.distance),
        nearest(d.nearest) {}

  KOKKOS_INLINE_FUNCTION Nearest nearest_of(Index block, const Real3& p) const {
    constexpr Real wider = Real(1.00001);  // than rounding can be
    Nearest found;
    Real nearest_yet = band * wider;
    found.square = nearest_yet * nearest_yet;
    for (Index e = start(block); e < start(block + 1); ++e) {
      const Index t = entry(e);
      const Real4 around = ball(t);
      const Real3 way = p - around.xyz();
      const Real within = (nearest_yet + around.w) * wider;
      if (dot(way, way) > within * within) continue;
      const Real3 a = x(corner(3 * t)), b = x(corner(3 * t + 1)), c = x(corner(3 * t + 2));
      const NearestPoint at = nearest_point(a, b, c, p);
      const Real3 apart = p - (at.weight[0] * a + at.weight[1] * b + at.weight[2] * c);
      const Real square = dot(apart, apart);
      if (square > found.square || (square == found.square && found.triangle >= 0 && t > found.triangle)) continue;
      found = {t, square, at};
      nearest_yet = Kokkos::sqrt(square);
    }
    return found;
  }
  /// On which side of the surface p is.
  KOKKOS_INLINE_FUNCTION Real side(const Nearest& found, const Real3& p) const {
    const std::int64_t t = 3 * static_cast<std::int64_t>(found.triangle);
    const NearestPoint& at = found.at;
    Real3 out = face(found.triangle);
    if (at.part < 3)
      out = normal(corner(t + at.part));
    else if (at.part < 6)
      out += face(neighbor(t + at.part - 3));
    const Real3 foot = at.weight[0] * x(corner(t)) + at.weight[1] * x(corner(t + 1)) + at.weight[2] * x(corner(t + 2));
    return dot(p - foot, out) < 0 ? Real(-1) : Real(1);
  }
  KOKKOS_INLINE_FUNCTION void operator()(const Index e) const {
    const Index i = e % lattice.points[0], row = e / lattice.points[0], j = row % lattice.points[1],
                k = row / lattice.points[1];
    const Real3 p = lattice.step * Real3{Real(i), Real(j), Real(k)};
    const Nearest found = nearest_of(lattice.block_of(i, j, k), p);
    nearest(e) = found.triangle;
    distance(e) = found.triangle < 0 ? band : side(found, p) * smaller(Kokkos::sqrt(found.square), band);
  }
};

/// Beyond the band a point is on the side of the one before it in its row: the band is wider than a step.
void fill_sides(DeformingBody& d) {
  const Entries<Real> distance = d.distance;
  const Entries<const Index> nearest = std::as_const(d).nearest;
  const Index length = d.lattice[0];
  const Real band = d.band;
  parallel(
      "drench::deforming_body::sides", d.lattice[1] * d.lattice[2], KOKKOS_LAMBDA(const Index row) {
        Real side = 1;
        for (Index e = row * length; e < (row + 1) * length; ++e) {
          if (nearest(e) < 0)
            distance(e) = side * band;
          else
            side = distance(e) < 0 ? Real(-1) : Real(1);
        }
      });
}

/// The body's entry of the solids: the lattice is centred at where its own is at the end of the step.
void place_solid(Bodies& bodies, DeformingBody& d, double time) {
  const Vec3 origin = lattice_origin(d.body, time);
  Double3 half;
  half.x = 0.5 * d.body.field.spacing * (d.lattice[0] - 1);
  half.y = 0.5 * d.body.field.spacing * (d.lattice[1] - 1);
  half.z = 0.5 * d.body.field.spacing * (d.lattice[2] - 1);
  const Real3 center = narrow(add({origin[0], origin[1], origin[2]}, half)), corner = narrow(times(-1, half));
  const Entries<Solid> solids = bodies.solids;
  const MovingSurface surface{d.nearest.data(), d.corner.data(), d.position.data(), d.velocity.data()};
  const Real* const field = d.distance.data();
  const Index index = d.index;
  parallel(
      "drench::deforming_body::solid", 1, KOKKOS_LAMBDA(const Index) {
        Solid& s = solids(index);
        s.center = s.point = center;
        s.field_origin = corner;
        s.field = field;
        s.surface = surface;
      });
}

}  // namespace

void place_surfaces(Bodies& bodies, const StepInfo& info) {
  for (const auto& shared : bodies.deforming) {
    DeformingBody& d = *shared;
    const bool stands = rate_after(d.body.shape, info.time) == 0;  // after its last file: every step is the same
    if (!(stands && d.stands) && (d.time != info.time || d.dt != info.dt)) {
      const auto count = static_cast<std::size_t>(Lattice(d).count());
      allocate_zeros(d.distance, "drench::deforming_distance", count);
      allocate_zeros(d.nearest, "drench::deforming_nearest", count);
      move_points(d, info);
      turn_normals(d);
      list_triangles(d);
      parallel("drench::deforming_body::distances", Lattice(d).count(), Distances(d));
      fill_sides(d);
      d.time = info.time;
      d.dt = info.dt;
      d.stands = stands;
    }
    place_solid(bodies, d, info.time + info.dt);
  }
}

}  // namespace drench::kokkos_backend
