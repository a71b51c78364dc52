// Bodies that change their shape: their arrays and their samples.

#include "bodies/deforming_body.hpp"

#include <algorithm>
#include <map>

#include "core/host_copy.hpp"
#include "state/deforming_body.hpp"

namespace drench::kokkos_backend {
namespace {

using Points = std::vector<Vec3>;

/// Into an array that is as long already, or is made so. Double3 has the layout of Vec3.
void upload_doubles(Field<Double3>& a, const char* label, const std::vector<std::array<double, 3>>& values) {
  static_assert(sizeof(Double3) == sizeof(Vec3));
  make_room(a, label, values.size());
  copy_now(a, Kokkos::View<const Double3*, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>(
                  reinterpret_cast<const Double3*>(values.data()), values.size()));
}

/// Of each triangle and corner: the triangle on the other side of the opposite edge.
std::vector<Index> neighbors_of(const std::vector<std::array<Index, 3>>& triangles) {
  std::map<std::pair<Index, Index>, Index> side;  // directed: of a closed, oriented mesh each occurs once
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      side[{triangles[t][(c + 1) % 3], triangles[t][(c + 2) % 3]}] = static_cast<Index>(t);
  std::vector<Index> neighbors;
  for (const auto& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) neighbors.push_back(side.at({t[(c + 2) % 3], t[(c + 1) % 3]}));
  return neighbors;
}

/// Which slot holds a file; one that `other` does not need is given up for it.
const Field<Double3>& hold(DeformingBody& d, std::size_t wanted, const std::array<std::size_t, 4>& needed) {
  const auto number = static_cast<std::int64_t>(wanted);
  for (std::size_t slot = 0; slot < d.file.size(); ++slot)
    if (d.held[slot] == number) return d.file[slot];
  const auto is_needed = [&](std::int64_t file) {
    return std::any_of(needed.begin(), needed.end(),
                       [&](std::size_t k) { return static_cast<std::int64_t>(k) == file; });
  };
  std::size_t slot = 0;
  while (is_needed(d.held[slot])) ++slot;
  upload_doubles(d.file[slot], "drench::deforming_file", d.body.shape.points[wanted]);  // a stage allocates nothing
  d.held[slot] = number;
  return d.file[slot];
}

}  // namespace

PointsOfStep points_of_step(DeformingBody& d, double time, double dt) {
  const FilePart begin = files_at(d.body.shape.time, time), end = files_at(d.body.shape.time, time + dt);
  const std::array<std::size_t, 4> needed{begin.first, begin.last, end.first, end.last};
  const auto held = [&](std::size_t file) { return Entries<const Double3>(hold(d, file, needed)); };
  return {{held(begin.first), held(begin.last), begin.part}, {held(end.first), held(end.last), end.part}};
}

DeformingBody::DeformingBody(const Body& of, Index number)
    : body(of),
      index(number),
      points(static_cast<Index>(of.mesh_points.size())),
      triangles(static_cast<Index>(of.mesh_triangles.size())),
      first_sample(of.first_sample),
      samples(of.sample_count),
      band(Real(of.shape.band)),
      step(Real(of.field.spacing)),
      lattice(of.field.points),
      corner(to_device<Index>("drench::deforming_corner", flat(of.mesh_triangles))),
      neighbor(to_device<Index>("drench::deforming_neighbor", neighbors_of(of.mesh_triangles))) {
  for (std::size_t a = 0; a < 3; ++a) blocks[a] = (lattice[a] + block_edge - 1) / block_edge;
  std::vector<std::vector<Index>> rows(of.mesh_points.size());
  for (std::size_t t = 0; t < of.mesh_triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      rows[static_cast<std::size_t>(of.mesh_triangles[t][c])].push_back(static_cast<Index>(4 * t + c));
  std::vector<Index> start{0}, items;
  for (const auto& row : rows) {
    items.insert(items.end(), row.begin(), row.end());
    start.push_back(static_cast<Index>(items.size()));
  }
  point_start = to_device<Index>("drench::deforming_point_start", start);
  item = to_device<Index>("drench::deforming_point_triangles", items);
  if (samples == 0) return;
  sample_triangle = to_device<Index>("drench::deforming_sample_triangle", of.shape.triangle);
  upload_doubles(sample_weight, "drench::deforming_sample_weight", of.shape.weight);
  sample_depth = to_device<double>("drench::deforming_sample_depth", of.shape.depth);
}

void make_deforming(const Constants& constants, Bodies& bodies) {
  const std::vector<Body>& all = constants.model.bodies;
  for (std::size_t b = 0; b < all.size(); ++b)
    if (all[b].deforms()) bodies.deforming.push_back(std::make_shared<DeformingBody>(all[b], static_cast<Index>(b)));
}

MemoryEstimate deforming_bytes(const Sizing& s) {
  constexpr double block = DeformingBody::block_edge * DeformingBody::block_edge * DeformingBody::block_edge;
  const SetupSize& n = s.size;
  MemoryEstimate sum;
  // nearest, blocks and their triangles; distances are counted with all fields (body_bytes)
  sum.bodies +=
      n.deforming_field * (index_bytes * (1 + 2 / block) + s.real / block) + n.deforming_pairs * 1.25 * index_bytes;
  sum.bodies += n.deforming_points * (4 * 3 * double_bytes + 9 * s.real + index_bytes);     // files, position, …
  sum.bodies += n.deforming_triangles * (9 * index_bytes + 7 * s.real);                     // corner, …, ball
  if (n.deforming_points > 0) sum.bodies += n.boundary * (index_bytes + 4 * double_bytes);  // where samples are
  sum.host += n.deforming_files * 3 * double_bytes;
  return sum;
}

namespace {

/// What places a sample: p = Σ w x − z n, with the unit normal n of its triangle; the same of velocities.
struct SamplePlaces {
  Entries<const Index> triangle, corner;
  Entries<const Double3> weight;
  Entries<const double> depth;

  explicit SamplePlaces(const DeformingBody& d)
      : triangle(d.sample_triangle), corner(d.corner), weight(d.sample_weight), depth(d.sample_depth) {}

  struct Corners {
    Double3 a, b, c;
  };
  template <class Of>
  KOKKOS_INLINE_FUNCTION Corners corners(Index s, const Of& of) const {
    const std::int64_t t = 3 * static_cast<std::int64_t>(triangle(s));
    return {of(corner(t)), of(corner(t + 1)), of(corner(t + 2))};
  }
  KOKKOS_INLINE_FUNCTION Double3 mixed(Index s, const Corners& x) const {
    const Double3 w = weight(s);
    return add(add(times(w.x, x.a), times(w.y, x.b)), times(w.z, x.c));
  }
  KOKKOS_INLINE_FUNCTION static Double3 across(const Corners& x) { return outer(minus(x.b, x.a), minus(x.c, x.a)); }
  KOKKOS_INLINE_FUNCTION Double3 position(Index s, const Corners& x) const {
    const Double3 n = across(x);
    const double length = Kokkos::sqrt(inner(n, n));
    return minus(mixed(s, x), times(length > 0 ? depth(s) / length : 0, n));
  }
  /// dn/dt = (c' − n (n·c'))/|c| of n = c/|c|.
  KOKKOS_INLINE_FUNCTION Double3 velocity(Index s, const Corners& x, const Corners& v) const {
    const Double3 c = across(x);
    const double square = inner(c, c);
    if (!(square > 0)) return mixed(s, v);
    const Double3 rate = add(outer(minus(v.b, v.a), minus(x.c, x.a)), outer(minus(x.b, x.a), minus(v.c, v.a)));
    const Double3 turning = minus(rate, times(inner(c, rate) / square, c));
    return minus(mixed(s, v), times(depth(s) / Kokkos::sqrt(square), turning));
  }
};

void set_velocities(Bodies& bodies, DeformingBody& d, const StepInfo& info) {
  const PointsOfStep points = points_of_step(d, info.time, info.dt);
  const SamplePlaces places(d);
  const Entries<Real3> v = bodies.boundary.velocity, predicted = bodies.dynamic.predicted;
  const bool dynamic = bodies.dynamic.count > 0;
  const Index first = d.first_sample;
  const double rate = 1 / info.dt;
  parallel(
      "drench::deforming_body::sample_velocity", d.samples, KOKKOS_LAMBDA(const Index s) {
        const Double3 before = places.position(s, places.corners(s, points.begin)),
                      after = places.position(s, places.corners(s, points.end));
        v(first + s) = narrow(times(rate, minus(after, before)));
        if (dynamic) predicted(first + s) = v(first + s);
      });
}

void place(Bodies& bodies, DeformingBody& d, double time) {
  const PointsBetween points = points_of_step(d, time, 0).begin;
  const double rate = rate_after(d.body.shape, time);
  const SamplePlaces places(d);
  const Entries<Real3> x = bodies.boundary.position, v = bodies.boundary.velocity, predicted = bodies.dynamic.predicted;
  const bool dynamic = bodies.dynamic.count > 0;
  const Index first = d.first_sample;
  parallel(
      "drench::deforming_body::samples", d.samples, KOKKOS_LAMBDA(const Index s) {
        const SamplePlaces::Corners now = places.corners(s, points);
        const SamplePlaces::Corners moving =
            places.corners(s, [&](const Index n) { return times(rate, minus(points.last(n), points.first(n))); });
        x(first + s) = narrow(places.position(s, now));
        v(first + s) = narrow(places.velocity(s, now, moving));
        if (dynamic) predicted(first + s) = v(first + s);
      });
}

void set_volumes(const Constants& constants, Bodies& bodies, const DeformingBody& d) {
  const Kernel kernel = constants.kernel;
  const CellTableView cells = bodies.cells.view();
  const Entries<const Real3> x = std::as_const(bodies).boundary.position;
  const Entries<const Index> of = std::as_const(bodies).boundary.body;
  const Entries<Real> volume = bodies.boundary.volume;
  const Real share = Real(constants.model.layer_share);
  const Index first = d.first_sample, body = d.index;
  parallel(
      "drench::deforming_body::sample_volume", d.samples, KOKKOS_LAMBDA(const Index s) {
        const Real3 here = x(first + s);
        Real sum = 0;
        cells.for_near(here, [&](const Index b) {
          if (of(b) == body) sum += kernel.value(norm(here - x(b)));
        });
        volume(first + s) = share / sum;
      });
}

}  // namespace

void set_sample_velocities(Bodies& bodies, const StepInfo& info) {
  for (const auto& d : bodies.deforming) set_velocities(bodies, *d, info);
}

void place_deforming_samples(Bodies& bodies, double time) {
  for (const auto& d : bodies.deforming) place(bodies, *d, time);
}

void refresh_sample_volumes(const Constants& constants, Bodies& bodies) {
  if (bodies.deforming.empty() || bodies.boundary.count == 0) return;
  refresh_boundary_cells(constants, bodies);
  for (const auto& d : bodies.deforming) set_volumes(constants, bodies, *d);
}

}  // namespace drench::kokkos_backend
