#pragma once
// What Newton's method for the cloth asks of one node next to solids, on a host and on a GPU: where the solids are, who
// touches them, who sticks and who slips (docs/theory/cloth.md, section 8).

#include <Eigen/LU>

#include "cloth/node_vectors.hpp"
#include "cloth/slip.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {

enum class ContactState : std::uint8_t { apart, sticks, slips };

/// What contact leaves a node: directions in which it is free, and how friction changes its row.
struct NodeFreedom {
  Matrix3 free;          // Q: I, without a normal, or 0
  Matrix3 turning;       // N/m: friction's change with the direction of slip
  Column3 drag, normal;  // μ e and n of a slipping node: friction follows the pressing force
  bool all = true;       // Q = I, and there is no friction
};

/// A node next to solids: the planes that it must stay in front of, and what contact says of its residual.
struct NodeNearby {
  static constexpr int most = 3;
  int count = 0;             // of planes
  bool pinched = false;      // between two solids that squeeze it: it stays on the one plane halfway between them
  std::int64_t solid[most];  // of each plane; the two of a pinched node
  Double3 normal[most];      // of unit length
  double gap[most];          // m, along the normal up to the surface that keeps the clearance
  Double3 moved;             // of the surface in the step, m
  NodeContact<double> contact;
  Double3 left;          // what contact leaves of the residual, without friction, N
  bool blocked = false;  // friction presses it into a plane beside those that it is pressed onto

  /// What presses the node into its planes, N. `touching`: a bit of each that it is brought onto. Where it is one alone
  /// that does not press yet, what will press there.
  KOKKOS_INLINE_FUNCTION double press(const Double3& residual, std::uint8_t touching) const {
    const bool one = touching != 0 && (touching & (touching - 1)) == 0;
    if (pinched || !one || (count > 1 && contact.press > 0)) return contact.press;
    return larger(0.0, -dot(residual, normal[touching >> 1]));
  }
};
static_assert(NodeNearby::most == 3, "bit k of 1, 2 and 4 is that number shifted by one");

/// How Newton's method sees solids: the mean edge, m, and where pressed nodes end, of the thickness beyond clearance.
struct SolidSight {
  double mean_edge, margin;
};
inline constexpr double margin_at_dynamic_bodies = 0.002;

// Of Newton's method, on a host and on a GPU.
inline constexpr int most_iterations = 40;   // of one solve
inline constexpr double forcing = 0.05;      // of the linear residual that may be left
inline constexpr double no_progress = 1e-8;  // of the square of the linear residual, if an iteration takes away no more
inline constexpr Index many_changed =
    20;  // nodes whose free directions differ from the preconditioner's: it is renewed
inline constexpr Real other_directions = Real(0.02);  // squared: from there on they differ
inline constexpr double most_growth = 2;              // of the residual that a step may cause
inline constexpr int most_halvings = 3;               // of a step
inline constexpr int late_after = 6;       // iterations: then what presses touches, whatever sweeps foresee, ...
inline constexpr Index many_toggled = 40;  // ... if so many nodes still change their state, ...
inline constexpr int stands_after = 12;    // ... or, in every other four iterations, if the residual does not fall
inline constexpr int slow_after = 4;       // iterations: from then on a residual that has not halved in three is slow
inline constexpr double same_way =
    0.3;                               // cosine between two steps of a slow solve above which the second is lengthened
inline constexpr double longest = 32;  // times the Newton step: the most that it is lengthened

/// The solid that squeezes a node together with solid b, where the node touches both: on the other side of the
/// narrowest gap; -1 if there is none.
KOKKOS_INLINE_FUNCTION std::int64_t opposite_solid(const ClothSystem& s, std::int64_t b, const NearSolid<double>& own,
                                                   const NodeTerms& t, const Double3& shift) {
  std::int64_t found = -1;
  double least = 1e300;
  DRENCH_ROLLED
  for (std::int64_t a = 0; a < s.solids.count; ++a) {
    if (a == b) continue;
    const NearSolid<double> other = near_solid(s.solids(a), t.start, shift, t.clearance);
    if (!(other.at.phi < least)) continue;
    if (!squeezed(s.solids(a), other, s.solids(b), own, t.start, shift, t.clearance.thickness)) continue;
    found = a;
    least = other.at.phi;
  }
  return found;
}

/// Fills `near`. Returns how much farther the nearest solid is than what could matter, m; 0 if that is not known.
KOKKOS_INLINE_FUNCTION double see_solids(const ClothSystem& s, const NodeTerms& t, const SolidSight& sight,
                                         const Double3& shift, const Double3& residual, NodeNearby& near) {
  near.count = 0;
  near.pinched = near.blocked = false;
  near.left = residual;
  near.contact = {};
  NearSolid<double> first{};
  double beyond[NodeNearby::most];       // how much farther each is than it has to be, m
  double nearest = 1e300, farthest = 0;  // of the solids
  double narrowest = 1e300;              // of the gaps that squeeze the node
  const double thickness = double(t.clearance.thickness), reach = thickness + larger(thickness, 0.2 * sight.mean_edge);
  DRENCH_ROLLED
  for (std::int64_t b = 0; b < s.solids.count && near.count < NodeNearby::most; ++b) {
    const Solid& solid = s.solids(b);
    const NearSolid<double> own = near_solid(solid, t.start, shift, t.clearance);
    const SolidDistance<double>& d = own.at;
    nearest = smaller(nearest, d.phi);
    if (solid.body == static_cast<Index>(b)) farthest = larger(farthest, d.phi);  // second parts are beside first ones
    if (!(d.phi < reach)) continue;
    const std::int64_t opposite = opposite_solid(s, b, own, t, shift);
    if (opposite >= 0) {
      const NearSolid<double> other = near_solid(s.solids(opposite), t.start, shift, t.clearance);
      if (d.phi + other.at.phi >= narrowest) continue;
      narrowest = d.phi + other.at.phi;
      near.pinched = true;
      near.solid[0] = b;
      near.solid[1] = opposite;
      const Halfway<double> halfway(own, other);
      near.normal[0] = halfway.normal;
      near.gap[0] = halfway.beyond;
      near.moved = double(s.dt) * surface_velocity(solid, t.start, shift);
      near.count = 1;
      continue;
    }
    if (near.pinched) continue;
    int k = 0;
    while (k < near.count && !alike(s.solids(near.solid[k]), near.normal[k], solid, d.normal)) ++k;
    if (k < near.count && !(d.phi - own.kept < beyond[k])) continue;
    if (near.count < k + 1) near.count = k + 1;
    beyond[k] = d.phi - own.kept;
    near.solid[k] = b;
    near.normal[k] = d.normal;
    // Within the width of contact, so that a dynamic body that ends the step a little nearer than was tried pushes
    // nothing.
    near.gap[k] = (d.phi - double(own.kept) - sight.margin * thickness) / d.slope;
    near.moved = double(s.dt) * surface_velocity(solid, t.start, shift);
    if (k == 0) first = own;
  }
  // Out of a mesh's lattice nothing is known.
  if (near.count == 0) return farthest < double(far_away) ? nearest - reach : 0;
  // Beyond the width of contact there is nothing to ask about.
  double gap = near.pinched ? -1 : 1e300;
  for (int k = 0; k < near.count; ++k) gap = smaller(gap, near.gap[k]);
  if (!(gap < 0.021 * thickness)) return 0;
  if (near.count == 1 && !near.pinched)
    near.contact = s.contact_with(static_cast<std::size_t>(near.solid[0]), first, t, shift, near.left);
  else
    near.contact = s.contact(t, shift, near.left, t.compression);
  if (near.contact.touches) near.moved = near.contact.moved;
  return 0;
}

/// A step of a node that touches solids, as far as their surfaces go on as planes there: beyond an edge they do not.
KOKKOS_INLINE_FUNCTION Double3 within_planes(const ClothSystem& s, const NodeTerms& t, const NodeNearby& near,
                                             std::uint8_t touching, const Double3& shift, Double3 by) {
  constexpr double least_cosine = 0.8;
  constexpr int most_shortened = 4;
  if (touching == 0) return by;
  for (int shortened = 0; shortened < most_shortened; ++shortened) {
    bool turns = false;
    for (int k = 0; k < near.count && !turns; ++k) {
      if (!(touching >> k & 1)) continue;
      const auto distance = [&](int j) {
        return near_solid(s.solids(near.solid[j]), t.start, shift + by, t.clearance);
      };
      const Double3 normal = near.pinched ? Halfway<double>(distance(0), distance(1)).normal : distance(k).at.normal;
      turns = dot(normal, near.normal[k]) < least_cosine;
    }
    if (!turns) return by;
    by = 0.5 * by;
  }
  return by;
}

/// A node next to solids during the sweeps.
struct ZoneNode {
  Index node;
  Matrix3 inverse;       // of its block, m/N
  Column3 slip, toward;  // slip so far, m; direction of friction
  ContactState kind;     // apart: to be found out
};

KOKKOS_INLINE_FUNCTION ZoneNode zone_node(const NodeTerms& t, Index n, const NodeNearby& near, const Double3& shift,
                                          const Double3& residual, const Matrix3& own, ContactState before) {
  const double press = near.press(residual, near.count == 1 ? 1 : 0);
  const Double3 relative = shift - near.moved, normal = near.normal[0];
  const Slip slip(t, relative - dot(relative, normal) * normal, residual - dot(residual, normal) * normal, press);
  ZoneNode z{n, own.inverse(), column(slip.so_far), Column3::Zero(), ContactState::apart};
  // A force that brings it onto the surface in one Jacobi step is sure to press.
  if (!near.pinched && !(press > double(t.diagonal) * larger(0.0, near.gap[0] - 0.01 * double(t.clearance.thickness))))
    return z;
  const bool sticks = slip.length <= slip.loss || before == ContactState::sticks;
  z.kind = sticks ? ContactState::sticks : ContactState::slips;
  if (!sticks && slip.length > 0) z.toward = column((1 / slip.length) * slip.whole);
  return z;
}

/// Of two planes that a node would pass with `step`: the one onto which alone it has to be brought, or both.
KOKKOS_INLINE_FUNCTION std::uint8_t onto_one(const ZoneNode& z, const NodeNearby& near, const Column3& step) {
  const auto gap = [&](int k, const Column3& way) { return Real(near.gap[k]) + column(near.normal[k]).dot(way); };
  for (int k = 0; k < 2; ++k) {
    const Column3 normal = column(near.normal[k]), along = z.inverse * normal;
    const Column3 moved = step - gap(k, step) / normal.dot(along) * along;
    if (gap(1 - k, moved) >= 0) return std::uint8_t(1 << k);
  }
  return 3;
}

/// A step of nonlinear Gauss-Seidel: how a node moves on from `so_far` (m) with what is left of its row, r (N), and
/// which of its planes it then touches, a bit of each.
KOKKOS_INLINE_FUNCTION Column3 zone_step(ZoneNode& z, const NodeNearby& near, Real friction, const Column3& r,
                                         const Column3& so_far, std::uint8_t& touching) {
  Column3 step = z.inverse * r;
  touching = 0;
  for (int k = 0; k < near.count; ++k)
    if (near.pinched || Real(near.gap[k]) + column(near.normal[k]).dot(so_far + step) < 0)
      touching |= std::uint8_t(1 << k);
  if (near.count == 2 && near.blocked && touching != 0)
    touching = 3;
  else if (near.count == 2 && touching == 3)
    touching = onto_one(z, near, so_far + step);
  if (touching == 1 && z.kind == ContactState::sticks) {
    step = -z.slip - Real(near.gap[0]) * column(near.normal[0]) - so_far;
  } else if (touching == 1) {
    const Column3 normal = column(near.normal[0]);
    const Real gap = Real(near.gap[0]) + normal.dot(so_far + step);
    if (z.kind == ContactState::apart) {
      Column3 slip = z.slip + so_far + step;
      slip -= normal.dot(slip) * normal;
      const Real length = slip.norm();
      z.toward = length > 0 ? Column3(slip / length) : Column3(Column3::Zero());
      z.kind = ContactState::slips;
    }
    Column3 along = z.inverse * (normal - friction * z.toward);
    if (!(normal.dot(along) > 0)) along = z.inverse * normal;
    step -= gap / normal.dot(along) * along;
  } else if (touching != 0) {  // another one, or several: onto each in turn
    for (int k = 0; k < near.count; ++k) {
      if ((touching >> k & 1) == 0) continue;
      const Column3 normal = column(near.normal[k]), along = z.inverse * normal;
      const Real gap = Real(near.gap[k]) + normal.dot(so_far + step);
      if (gap < 0) step -= gap / normal.dot(along) * along;
    }
  }
  return step;
}

/// Does the node lie on one solid, and is it pressed into it?
KOKKOS_INLINE_FUNCTION bool lies_pressed(const NodeTerms& t, const NodeNearby& near, const Double3& residual) {
  constexpr double on_surface = 0.001;  // of the thickness
  return near.count == 1 && !near.pinched && dot(residual, near.normal[0]) < 0 &&
         near.gap[0] < on_surface * double(t.clearance.thickness);
}

/// How the squeezing force (26a) of two solids grows as the node slips along e into the gap, N/m; 0 if it slips out.
KOKKOS_INLINE_FUNCTION double narrowing(const ClothSystem& s, const NodeNearby& near, const NodeTerms& t,
                                        const Double3& shift, const Column3& e) {
  const double free_width = 2 * double(t.clearance.thickness), rigid = t.rigid_share;
  NearSolid<double> own[2];
  double width = 0;  // over that of the free cloth
  Column3 widening = Column3::Zero();
  for (int k = 0; k < 2; ++k) {
    own[k] = near_solid(s.solids(near.solid[k]), t.start, shift, t.clearance);
    width += own[k].at.phi / free_width;
    widening += column((own[k].at.slope / free_width) * own[k].at.normal);
  }
  const double unsqueezed = unsqueezed_width(own[0], own[1], double(t.clearance.thickness));
  if (!(width > rigid + 0.01 && width < unsqueezed)) return 0;
  const double rate = 2 * double(t.compression) * (unsqueezed - rigid) / ((width - rigid) * (width - rigid));
  return rate * larger(0.0, -double(widening.dot(e)));
}

/// An orthonormal basis of the normals that a node touches leaves `f.free`; the least correction brings it onto the
/// planes. Returns how many they are.
KOKKOS_INLINE_FUNCTION int planes_of(const NodeNearby& near, std::uint8_t touching, NodeFreedom& f,
                                     Column3& correction) {
  constexpr Real new_plane = Real(0.05);  // sine of the angle from which on a plane counts beside others
  int planes = 0;
  for (int k = 0; k < near.count; ++k) {
    if (!(touching >> k & 1)) continue;
    const Column3 own = column(near.normal[k]), fresh = f.free * own;
    const Real length = fresh.norm();
    if (length < new_plane) continue;
    const Column3 along = fresh / length;
    correction -= (Real(near.gap[k]) + own.dot(correction)) / length * along;
    f.free -= along * along.transpose();
    ++planes;
  }
  return planes;
}

/// A node's row of the linear system, as contact leaves it.
struct ContactRow {
  NodeFreedom freedom;
  Column3 right, correction;  // N; d_c, m
  ContactState state;
};

/// `touching`: a bit of each plane; `before`: its state; `slip_direction`: in which it slipped, and then slips.
KOKKOS_INLINE_FUNCTION ContactRow contact_row(const ClothSystem& s, Index n, std::uint8_t touching,
                                              const NodeNearby* nearby, const Double3& shift, const Double3& residual,
                                              ContactState before, Double3& slip_direction) {
  ContactRow row{{Matrix3::Identity(), Matrix3::Zero(), Column3::Zero(), Column3::Zero(), true},
                 column(residual),
                 Column3::Zero(),
                 before};
  NodeFreedom& f = row.freedom;
  if (s.pinned(n)) {
    f.all = false;
    f.free.setZero();
    row.right.setZero();
    return row;
  }
  row.state = ContactState::apart;
  if (nearby == nullptr || touching == 0) return row;
  const NodeNearby& near = *nearby;
  f.all = false;
  const int planes = planes_of(near, touching, f, row.correction);
  const NodeTerms t = s.terms(n);
  const bool one = planes == 1 && near.count == 1;
  const auto along = [&](const Double3& v) { return in_double(f.free * column(v)); };
  const Double3 relative = shift - near.moved;
  const Slip slip(t, counted_slip(relative, along(relative)), along(residual), near.press(residual, touching));
  const bool reversed = before == ContactState::slips && dot(slip.so_far, slip_direction) < 0;
  const double friction = double(t.diagonal) * slip.loss;  // N
  if (planes == 3 || slip.length <= slip.loss || reversed ||
      (before == ContactState::sticks && norm(slip.on) <= friction)) {
    row.state = ContactState::sticks;
    row.correction -= f.free * column(slip.so_far);
    f.free.setZero();
    row.right.setZero();
    return row;
  }
  row.state = ContactState::slips;
  slip_direction = (1 / slip.length) * slip.whole;
  row.right = column(slip.on - friction * slip_direction);
  if (!one) return row;
  const Column3 e = column(slip_direction);
  f.turning = Real(friction / slip.length) * (f.free - e * e.transpose());
  f.drag = t.friction * e;
  if (near.pinched)
    f.turning += Real(narrowing(s, near, t, shift, f.free * e)) * t.friction * e * e.transpose();
  else
    f.normal = column(near.normal[0]);
  return row;
}

}  // namespace drench::kokkos_backend
