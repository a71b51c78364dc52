// Who touches the solids, who sticks and who slips (docs/theory/cloth.md, section 8).

#include <algorithm>
#include <numeric>

#include "cloth/newton.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int zone_sweeps = 4;  // of Gauss-Seidel

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
    z = zone_node(s.terms(n), n, now_.near[at(n)], now_.shift[at(n)], now_.residual[at(n)], tangent_.own(n),
                  state_[at(n)]);
  });
}

void NewtonCloth::relax(const ClothSystem& s, ZoneNode& z) {
  const Index n = z.node;
  const Column3 r = at_node(zone_residual_, n), so_far = at_node(zone_change_, n);
  std::uint8_t touching = 0;
  const Column3 step = zone_step(z, now_.near[at(n)], s.friction(n), r, so_far, touching);
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
  for (const ZoneNode& z : zone_) {
    const std::size_t n = at(z.node);
    if (lies_pressed(s.terms(z.node), now_.near[n], now_.residual[n])) touching_[n] = 1;
  }
}

void NewtonCloth::set_contact_rows(const ClothSystem& s) {
  host_parallel("drench::cloth::newton_rows", nodes_, [&](const Index n) {
    const ContactState before = state_[at(n)];
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

void NewtonCloth::set_row(const ClothSystem& s, Index n) {
  const NodeNearby* const near = s.solids.count > 0 ? &now_.near[at(n)] : nullptr;
  const ContactRow row = contact_row(s, n, touching_[at(n)], near, now_.shift[at(n)], now_.residual[at(n)],
                                     state_[at(n)], slip_direction_[at(n)]);
  freedom_[at(n)] = row.freedom;
  at_node(right_, n) = row.right;
  at_node(correction_, n) = row.correction;
  state_[at(n)] = row.state;
}

}  // namespace drench::kokkos_backend
