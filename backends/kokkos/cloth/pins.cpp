#include "cloth/pins.hpp"

#include <algorithm>
#include <cmath>

#include "core/host_copy.hpp"
#include "core/host_parallel.hpp"
#include "state/keyed_motion.hpp"

namespace drench::kokkos_backend {
namespace {

using Matrix = std::array<Vec3, 3>;  // rows
constexpr Matrix one{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Rodrigues: cos θ 1 + sin θ [k]× + (1 − cos θ) k kᵀ.
Matrix rotation(const Vec3& k, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Matrix m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) m[i][j] = (i == j ? c : 0) + (1 - c) * k[i] * k[j];
  m[0][1] -= s * k[2];
  m[0][2] += s * k[1];
  m[1][0] += s * k[2];
  m[1][2] -= s * k[0];
  m[2][0] -= s * k[1];
  m[2][1] += s * k[0];
  return m;
}

/// `a` after the rotation by q; exactly `a` where q is none.
Matrix after(const Matrix& a, const drench::Quaternion& q) {
  if (q == drench::Quaternion{1, 0, 0, 0}) return a;
  const auto [w, x, y, z] = q;
  const Matrix b{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                  {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                  {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
  Matrix product{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) product[i][j] += a[i][k] * b[k][j];
  return product;
}

/// What turns from `first` to `last` about the centre, which ends at `offset` after `move`.
PinStep packed(const Vec3& center, const Matrix& first, const Matrix& last, const Vec3& offset, const Vec3& move) {
  PinStep step{};
  step.center = to_real(center);
  for (std::size_t a = 0; a < 3; ++a) {
    Vec3 change;
    for (std::size_t b = 0; b < 3; ++b) change[b] = last[a][b] - first[a][b];
    step.rotation[a] = to_real(last[a]);
    step.change[a] = to_real(change);
  }
  step.offset = to_real(offset);
  step.move = to_real(move);
  return step;
}

/// Of pins that follow a body.
PinStep step_with(const Body& body, const PinMotion& m, double from, double to) {
  const Vec3 before = way_at(body, from), way = way_at(body, to);
  Vec3 offset, move;
  for (std::size_t a = 0; a < 3; ++a) {
    offset[a] = body.center[a] + way[a];
    move[a] = way[a] - before[a];
  }
  return packed(m.center, after(one, orientation_at(body, from)), after(one, orientation_at(body, to)), offset, move);
}

PinStep step_of(const PinMotion& m, double from, double to) {
  const double begun = std::clamp(from, m.start, m.end) - m.start, done = std::clamp(to, m.start, m.end) - m.start;
  const auto turned = [&](double since) {
    if (m.rate.is_zero()) return after(one, m.rotated);
    const double angle = m.rate.has_keys() ? m.rate.integral(m.start, m.start + since) : m.rate.plain() * since;
    return after(rotation(m.axis, angle), m.rotated);
  };
  const Vec3 way = m.has_keys() ? m.velocity.integral(m.start, m.start + done) : Vec3{};
  const Vec3 part = m.has_keys() ? m.velocity.integral(m.start + begun, m.start + done) : Vec3{};
  const Vec3 path = m.path.at(m.start + done), path_before = m.path.at(m.start + begun);
  const Vec3& v = m.velocity.plain();
  Vec3 offset, move;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool keys = m.has_keys();
    offset[a] = m.center[a] + m.offset[a] + (keys ? way[a] + path[a] : v[a] * done);
    move[a] = keys ? part[a] + (path[a] - path_before[a]) : v[a] * (done - begun);
  }
  return packed(m.center, turned(begun), turned(done), offset, move);
}

}  // namespace

void find_moving_pins(const Model& model, Nodes& nodes) {
  nodes.pins_placed = Nodes::not_placed;
  nodes.pin_motion = Array<Index>();
  nodes.pin_stiffness = Array<Real>();
  if (!model.has_moving_pins()) return;
  nodes.pin_motion = to_device<Index>("drench::node_pin_motion", model.mesh.pin_motion);
  if (model.has_soft_pins())
    nodes.pin_stiffness = to_device<Real>("drench::node_pin_stiffness", model.mesh.pin_stiffness);
  if (!nodes.rest_position.exists())
    nodes.rest_position = to_device3("drench::node_rest_position", model.mesh.rest_position);
}

void shorten_stitches(Cloth& cloth, const StepInfo& info) {
  const Index stitches = cloth.mesh.stitches, first = cloth.mesh.edges - stitches;
  if (stitches == 0) return;
  const Entries<const double> at_start = cloth.mesh.stitch_length, ends = cloth.mesh.stitch_end;
  const Entries<const Index> of_stitch = cloth.mesh.stitch_link, edge = cloth.mesh.edge;
  const Entries<const Real3> x = cloth.nodes.position;
  const Entries<Real> length = cloth.mesh.edge_length;
  const Entries<Link> link = cloth.nodes.link;
  const double time = info.time + info.dt;
  parallel(
      "drench::cloth::stitches", stitches, KOKKOS_LAMBDA(const Index k) {
        const double part = time < ends(k) ? time / ends(k) : 1.0;
        const Real asked = static_cast<Real>(at_start(k) * (1 - part * part * (3 - 2 * part)));
        const Index e = 2 * (first + k);
        const Real now = smaller(asked, norm(x(edge(e)) - x(edge(e + 1))));
        length(first + k) = now;
        link(of_stitch(2 * k)).length = now;
        link(of_stitch(2 * k + 1)).length = now;
      });
}

void place_pins(const Constants& constants, Cloth& cloth, const StepInfo& info) {
  if (!constants.model.has_moving_pins()) return;
  if (cloth.nodes.pins_placed == std::array{info.time, info.dt}) return;
  cloth.nodes.pins_placed = {info.time, info.dt};
  const std::vector<PinMotion>& motions = constants.model.pin_motions;
  std::vector<PinStep> steps(motions.size());
  // One a node where they follow files.
  host_parallel("drench::cloth::pin_steps", static_cast<Index>(steps.size()), [&](const Index k) {
    const PinMotion& m = motions[static_cast<std::size_t>(k)];
    PinStep& step = steps[static_cast<std::size_t>(k)];
    step = m.body < 0
               ? step_of(m, info.time, info.time + info.dt)
               : step_with(constants.model.bodies[static_cast<std::size_t>(m.body)], m, info.time, info.time + info.dt);
    step.holds = m.holds(info.time, info.dt) ? 1 : 0;
  });
  if (cloth.pin_steps.extent(0) != steps.size()) cloth.pin_steps = Array<PinStep>("drench::pin_steps", steps.size());
  copy_now(cloth.pin_steps,
           Kokkos::View<PinStep*, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>(steps.data(), steps.size()));
}

}  // namespace drench::kokkos_backend
