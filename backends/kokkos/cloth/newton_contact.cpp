// Who touches the solids, who sticks and who slips (docs/theory/cloth.md, section 8).

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "cloth/newton.hpp"
#include "cloth/slip.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int zone_sweeps = 4;                 // of Gauss-Seidel
constexpr Real other_directions = Real(0.02);  // squared: from there on a node is free in others than in the factor
constexpr Real new_plane = Real(0.05);         // sine of the angle from which on a plane counts beside others

/// How the squeezing force (26a) of two solids grows as the node slips along e into the gap, N/m; 0 if it slips out.
double narrowing(const ClothSystem& s, const NodeNearby& near, const NodeTerms& t, const Double3& shift,
                 const Column3& e) {
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
  return rate * std::max(0.0, -double(widening.dot(e)));
}

}  // namespace

void NewtonCloth::begin_zone(const ClothSystem& s) {
  const auto is_near = [&](Index n) { return !s.pinned(n) && now_.near[at(n)].count > 0; };
  zone_start_.assign(at(tangent_.groups()) + 1, 0);
  for (Index n = 0; n < nodes_; ++n) {
    touching_[at(n)] = 0;
    if (is_near(n)) ++zone_start_[at(tangent_.group(n)) + 1];
  }
  std::partial_sum(zone_start_.begin(), zone_start_.end(), zone_start_.begin());
  zone_.resize(at(zone_start_.back()));
  std::vector<Index> next(zone_start_.begin(), zone_start_.end() - 1);
  for (Index n = 0; n < nodes_; ++n)
    if (is_near(n)) zone_[at(next[at(tangent_.group(n))]++)].node = n;
  host_parallel("drench::cloth::newton_zone", static_cast<Index>(zone_.size()), [&](const Index k) {
    ZoneNode& z = zone_[at(k)];
    const Index n = z.node;
    const NodeNearby& near = now_.near[at(n)];
    const NodeTerms t = s.terms(n);
    const double press = near.press(now_.residual[at(n)], near.count == 1 ? 1 : 0);
    const Double3 relative = now_.shift[at(n)] - near.moved, residual = now_.residual[at(n)], normal = near.normal[0];
    const Slip slip(t, relative - dot(relative, normal) * normal, residual - dot(residual, normal) * normal, press);
    z = {n, tangent_.own(n).inverse(), column(slip.so_far), Column3::Zero(), State::apart};
    // A force that brings it onto the surface in one Jacobi step is sure to press.
    if (near.pinched ||
        press > double(t.diagonal) * std::max(0.0, near.gap[0] - 0.01 * double(t.clearance.thickness))) {
      z.kind = slip.length <= slip.loss || state_[at(n)] == State::sticks ? State::sticks : State::slips;
      if (z.kind == State::slips && slip.length > 0) z.toward = column((1 / slip.length) * slip.whole);
    }
  });
}

/// Of two planes that a node would pass with `step`: the one onto which alone it has to be brought, or both.
std::uint8_t NewtonCloth::onto_one(const ZoneNode& z, const NodeNearby& near, const Column3& step) {
  const auto gap = [&](int k, const Column3& way) { return Real(near.gap[k]) + column(near.normal[k]).dot(way); };
  for (int k = 0; k < 2; ++k) {
    const Column3 normal = column(near.normal[k]), along = z.inverse * normal;
    if (gap(1 - k, step - gap(k, step) / normal.dot(along) * along) >= 0) return std::uint8_t(1 << k);
  }
  return 3;
}

void NewtonCloth::relax(const ClothSystem& s, ZoneNode& z) {
  const Index n = z.node;
  const NodeNearby& near = now_.near[at(n)];
  const Column3 r = at_node(zone_residual_, n), so_far = at_node(zone_change_, n);
  Column3 step = z.inverse * r;
  std::uint8_t touching = 0;
  for (int k = 0; k < near.count; ++k)
    if (near.pinched || Real(near.gap[k]) + column(near.normal[k]).dot(so_far + step) < 0)
      touching |= std::uint8_t(1 << k);
  if (near.count == 2 && near.blocked && touching != 0)
    touching = 3;
  else if (near.count == 2 && touching == 3)
    touching = onto_one(z, near, so_far + step);
  if (touching == 1 && z.kind == State::sticks) {
    step = -z.slip - Real(near.gap[0]) * column(near.normal[0]) - so_far;
  } else if (touching == 1) {
    const Column3 normal = column(near.normal[0]);
    const Real gap = Real(near.gap[0]) + normal.dot(so_far + step);
    if (z.kind == State::apart) {
      Column3 slip = z.slip + so_far + step;
      slip -= normal.dot(slip) * normal;
      z.toward = slip.norm() > 0 ? slip.normalized() : Column3(Column3::Zero());
      z.kind = State::slips;
    }
    Column3 along = z.inverse * (normal - s.friction(n) * z.toward);
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
  touching_[at(n)] = touching;
  at_node(zone_change_, n) = so_far + step;
  at_node(zone_step_, n) = step;
  at_node(zone_residual_, n) = r - tangent_.own(n) * step;
  tangent_.subtract_change(n, step, zone_residual_);
}

void NewtonCloth::find_touching(const ClothSystem& s) {
  if (s.solids.count == 0) return;
  begin_zone(s);
  if (zone_.empty()) return;
  for (Index n = 0; n < nodes_; ++n) at_node(zone_residual_, n) = column(now_.residual[at(n)]);
  std::fill(zone_change_.begin(), zone_change_.end(), Real(0));
  std::fill(zone_step_.begin(), zone_step_.end(), Real(0));
  for (int sweep = 0; sweep < zone_sweeps; ++sweep) {
    if (sweep > 0)
      host_parallel("drench::cloth::newton_groups", static_cast<Index>(zone_.size()), [&](const Index z) {
        const Index n = zone_[at(z)].node;
        at_node(zone_residual_, n) -= tangent_.from_other_groups(n, zone_step_);
      });
    host_parallel("drench::cloth::newton_sweep", tangent_.groups(), [&](const Index group) {
      for (Index z = zone_start_[at(group)]; z < zone_start_[at(group + 1)]; ++z) relax(s, zone_[at(z)]);
    });
  }
  if (late_) touch_where_pressed(s);
}

/// What lies on one solid and is pressed touches it, as in primal-dual active sets (Hintermüller et al. 2002). What
/// sweeps foresee of hundreds of nodes may alternate without end.
void NewtonCloth::touch_where_pressed(const ClothSystem& s) {
  constexpr double on_surface = 0.001;  // of the thickness
  for (const ZoneNode& z : zone_) {
    const std::size_t n = at(z.node);
    const NodeNearby& near = now_.near[n];
    if (near.count != 1 || near.pinched) continue;
    const bool pressed = dot(now_.residual[n], near.normal[0]) < 0;
    if (pressed && near.gap[0] < on_surface * double(s.clearance(z.node).thickness)) touching_[n] = 1;
  }
}

void NewtonCloth::set_contact_rows(const ClothSystem& s) {
  host_parallel("drench::cloth::newton_rows", nodes_, [&](const Index n) {
    const State before = state_[at(n)];
    set_row(s, n);
    toggles_[at(n)] = state_[at(n)] != before;
  });
  changed_ = toggled_ = 0;
  if (s.solids.count == 0) return;
  const auto count = [this](const char* label, const auto& is) {
    return static_cast<Index>(sums_(label, nodes_, [&](const Index n) { return is(n) ? 1.0 : 0.0; }));
  };
  toggled_ = count("drench::cloth::newton_toggled", [this](Index n) { return toggles_[at(n)] != 0; });
  if (!warm_) return;
  changed_ = count("drench::cloth::newton_changed", [this](Index n) {
    return (freedom_[at(n)].free - factor_free_[at(n)]).squaredNorm() > other_directions;
  });
}

/// An orthonormal basis of the normals that a node touches leaves `freedom`; the least correction brings it onto the
/// planes.
int NewtonCloth::planes_of(const NodeNearby& near, std::uint8_t touching, NodeFreedom& f, Column3& correction) const {
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

void NewtonCloth::set_row(const ClothSystem& s, Index n) {
  NodeFreedom& f = freedom_[at(n)];
  f = {Matrix3::Identity(), Matrix3::Zero(), Column3::Zero(), Column3::Zero(), true};
  at_node(correction_, n).setZero();
  at_node(right_, n) = column(now_.residual[at(n)]);
  if (s.pinned(n)) {
    f.all = false;
    f.free.setZero();
    at_node(right_, n).setZero();
    return;
  }
  State& state = state_[at(n)];
  if (s.solids.count == 0 || touching_[at(n)] == 0) {
    state = State::apart;
    return;
  }
  const NodeNearby& near = now_.near[at(n)];
  f.all = false;
  Column3 correction = Column3::Zero();
  const int planes = planes_of(near, touching_[at(n)], f, correction);
  const NodeTerms t = s.terms(n);
  const bool one = planes == 1 && near.count == 1;
  const auto along = [&](const Double3& v) { return in_double(f.free * column(v)); };
  const Double3 relative = now_.shift[at(n)] - near.moved, residual = now_.residual[at(n)];
  const Slip slip(t, counted_slip(relative, along(relative)), along(residual), near.press(residual, touching_[at(n)]));
  const bool reversed = state == State::slips && dot(slip.so_far, slip_direction_[at(n)]) < 0;
  const double friction = double(t.diagonal) * slip.loss;  // N
  if (planes == 3 || slip.length <= slip.loss || reversed || (state == State::sticks && norm(slip.on) <= friction)) {
    state = State::sticks;
    correction -= f.free * column(slip.so_far);
    f.free.setZero();
    at_node(right_, n).setZero();
  } else {
    state = State::slips;
    const Double3 toward = (1 / slip.length) * slip.whole;
    slip_direction_[at(n)] = toward;
    at_node(right_, n) = column(slip.on - friction * toward);
    if (one) {
      const Column3 e = column(toward);
      f.turning = Real(friction / slip.length) * (f.free - e * e.transpose());
      f.drag = t.friction * e;
      if (near.pinched)
        f.turning += Real(narrowing(s, near, t, now_.shift[at(n)], f.free * e)) * t.friction * e * e.transpose();
      else
        f.normal = column(near.normal[0]);
    }
  }
  at_node(correction_, n) = correction;
}

}  // namespace drench::kokkos_backend
