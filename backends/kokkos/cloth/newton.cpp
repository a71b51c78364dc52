#include "cloth/newton.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/stop_request.hpp"
#include "cloth/host_cloth.hpp"
#include "cloth/solver.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr int most_linear = 60;             // iterations of a linear solve
constexpr double factor_cost = 8;           // a new factor takes as long as so many linear iterations
constexpr int usual_linear = 10;            // iterations of a linear solve with a factor of all pairs
constexpr Index few_toggled = 2;            // nodes that may change their state while steps are combined
constexpr double rounding = 0.5 * 2.2e-16;  // of Σ D L: what the sums leave of a residual

}  // namespace

NewtonCloth::NewtonCloth(const Cloth& cloth, const ClothSystem& system)
    : nodes_(cloth.nodes.count),
      exact_(cloth, system),
      tangent_(cloth, system),
      anderson_(nodes_),
      sight_{double(cloth.mesh.mean_edge), 0} {
  const std::size_t n = at(nodes_);
  for (Iterate* i : {&now_, &next_}) {
    i->shift.resize(n);
    i->elastic.resize(n);
    i->residual.resize(n);
    i->left.resize(3 * n);
    if (system.solids.count > 0) i->near.resize(n);
  }
  state_.resize(n);
  slip_direction_.resize(n);
  touching_.resize(n);
  toggles_.resize(n);
  freedom_.resize(n);
  factor_free_.resize(n, Matrix3::Identity());
  for (NodeVector* v : {&right_, &change_, &plain_, &correction_, &room_, &zone_change_, &zone_step_, &zone_residual_})
    v->resize(3 * n);
}

void NewtonCloth::prepare(const Cloth& cloth, const ClothSystem& s, bool pushes_bodies) {
  fresh_ = true;
  sight_.margin = pushes_bodies ? margin_at_dynamic_bodies : 0;
  const bool same_step = placed_ == cloth.moved && dt_ == s.dt;
  if (!same_step || pushes_bodies) away_.assign(s.solids.count > 0 ? at(nodes_) : 0, {});
  if (same_step) return;
  exact_.begin_step(s);
  placed_ = cloth.moved;
  dt_ = s.dt;
  warm_ = false;
  excess_ = 0;
  tangent_.hold_edges();
  cost_ = factor_cost;
  std::fill(state_.begin(), state_.end(), ContactState::apart);
}

double NewtonCloth::goal_of(const ClothSystem& s, double tolerance) {
  return sums_("drench::cloth::newton_goal", nodes_, [&](const Index n) {
    return s.pinned(n) ? 0.0 : ClothSystem::goal(s.terms(n), tolerance, rounding * sight_.mean_edge);
  });
}

void NewtonCloth::measure(const ClothSystem& s, Iterate& i) {
  if (!i.has_elastic) exact_.evaluate_elastic(s, i.shift, i.elastic);
  i.has_elastic = true;
  exact_.add_inertia(s, i.shift, i.elastic, i.residual);
  const bool solids = s.solids.count > 0;
  const double sum = sums_("drench::cloth::newton_measure", nodes_, [&](const Index n) {
    Double3 left = i.residual[at(n)];
    if (solids && !s.pinned(n)) {
      NodeNearby& near = i.near[at(n)];
      see_solids(s, n, i.shift[at(n)], i.residual[at(n)], near);
      left = near.left;
      if (near.contact.press > 0)
        left = ClothSystem::unbalanced(s.terms(n), i.shift[at(n)], near.contact, near.left, &near.blocked);
    }
    at_node(i.left, n) = column(left);
    return norm(left);
  });
  constexpr double lost = 1e100;  // also where numbers are not finite
  i.over_goal = sum == 0 ? 0 : sum / goal_;
  if (!(i.over_goal < lost)) i.over_goal = lost;
}

/// Is the node still out of the solids' reach? The distance from a solid changes at most as fast as the node moves, an
/// interpolated one at most twice as fast.
bool NewtonCloth::is_away(Index n, const Double3& shift) const {
  return away_[at(n)].room > 2 * norm(shift - away_[at(n)].shift);
}

void NewtonCloth::see_solids(const ClothSystem& s, Index n, const Double3& shift, const Double3& residual,
                             NodeNearby& near) {
  if (is_away(n, shift)) {
    near.count = 0;
    near.pinched = near.blocked = false;
    near.left = residual;
    near.contact = {};
    return;
  }
  const double room = kokkos_backend::see_solids(s, s.terms(n), sight_, shift, residual, near);
  if (room > 0) away_[at(n)] = {shift, room};
}

void NewtonCloth::start(const ClothSystem& s, const Entries<const Real3>& displacement) {
  host_parallel("drench::cloth::newton_begin", nodes_, [&](const Index n) {
    Double3& shift = now_.shift[at(n)];
    shift = widen(displacement(n));
    if (!s.pinned(n) && s.solids.count > 0 && !is_away(n, shift))
      shift = project_out(s.solids, s.start(n), shift, s.clearance(n));
  });
  now_.has_elastic = false;
}

bool NewtonCloth::run(const Entries<const Real3>& displacement, const ClothSystem& s, ClothProgress& progress, int most,
                      double tolerance) {
  if (fresh_) start(s, displacement);
  fresh_ = false;
  goal_ = goal_of(s, tolerance);
  measure(s, now_);
  anderson_.clear();
  double best = now_.over_goal;
  Vectors best_shift;
  std::vector<double> past;
  const int cap = std::min(most, most_iterations);
  for (int k = 0; k < cap && !(now_.over_goal <= 1 && k > 0); ++k) {
    stop_if_requested();
    slow_ = k >= slow_after && now_.over_goal > 0.5 * past[at(k - 3)];
    const bool stands = slow_ && k >= stands_after && k / 4 % 2 == 1;
    late_ = stands || (k >= late_after && toggled_ > many_toggled);
    past.push_back(now_.over_goal);
    if (slow_ && relax_locally(s)) {
      ++progress.iterations;
      if (now_.over_goal <= 1) break;
    }
    iterate(s, k == 0);
    ++progress.iterations;
    if (now_.over_goal > best) continue;
    best = now_.over_goal;
    if (best > 1) best_shift = now_.shift;
  }
  if (now_.over_goal > 1 && !best_shift.empty()) {
    now_.shift = best_shift;
    now_.has_elastic = false;
  }
  progress.residual = std::min(best, now_.over_goal);
  return progress.residual <= 1 || cap == most;
}

void NewtonCloth::write_result(const ClothSystem& s, const Entries<Real3>& displacement) const {
  host_parallel("drench::cloth::newton_end", nodes_, [&](const Index n) {
    if (!s.pinned(n)) displacement(n) = narrow(now_.shift[at(n)]);
  });
}

double NewtonCloth::cosine_between(const NodeVector& a, const NodeVector& b) {
  const double product = std::sqrt(sums_.dot(a, a) * sums_.dot(b, b));
  return product > 0 ? sums_.dot(a, b) / product : 0;
}

void NewtonCloth::iterate(const ClothSystem& s, bool first) {
  if (!first || !warm_) tangent_.update(s, now_.shift);
  find_touching(s);
  set_contact_rows(s);
  choose_factor(s);
  // A factor is made again when the old one has cost as many linear iterations more than it took when it was new.
  const bool fresh_factor = !warm_ || changed_ > many_changed || spent_ > cost_;
  if (fresh_factor) {
    tangent_.factor(s, freedom_);
    host_parallel("drench::cloth::newton_factored", nodes_,
                  [this](const Index n) { factor_free_[at(n)] = freedom_[at(n)].free; });
    warm_ = true;
    spent_ = 0;
  }
  const int done = solve_linear(s), linear = stagnates_ ? most_linear : done;  // such a factor is of no use
  if (fresh_factor) linear_when_new_ = done;
  excess_ += std::max(0, linear - usual_linear);
  spent_ += std::max(0, linear - linear_when_new_);
  // In a buckling sheet the tangent is too stiff, because it omits the negative terms of the Hessian: all steps point
  // the same way and are too short. Steps of opposite directions overshoot.
  const double turn = slow_ ? cosine_between(change_, plain_) : 0;
  first_length_ = turn > same_way ? std::min(2 * first_length_, longest) : turn < 0 ? 0.5 : 1;
  plain_ = change_;
  if (toggled_ > few_toggled) anderson_.clear();
  const bool combined = anderson_.combine(now_.shift, now_.left, change_);
  move(s, now_);
  if (combined && next_.over_goal > now_.over_goal) {
    anderson_.clear();
    change_ = plain_;
    move(s, now_);
  }
  std::swap(now_, next_);
}

/// Once the linear iterations that a factor of all pairs would have saved in this time step have cost as much as that
/// factor, it replaces the cheap one.
void NewtonCloth::choose_factor(const ClothSystem& s) {
  if (tangent_.holds_all() || !(excess_ > tangent_.cost_of_all())) return;
  tangent_.hold_all(s);
  if (!tangent_.holds_all()) return;
  warm_ = false;
  cost_ = std::max(factor_cost, tangent_.cost_of_all());
}

void NewtonCloth::move(const ClothSystem& s, const Iterate& from) {
  double length = first_length_;
  for (int halvings = 0;; ++halvings) {
    host_parallel("drench::cloth::newton_move", nodes_, [&](const Index n) {
      Double3& to = next_.shift[at(n)];
      to = from.shift[at(n)];
      if (s.pinned(n)) return;
      const Double3 by = length * in_double(at_node(change_, n));
      to += touching_[at(n)] == 0 ? by : within_planes(s, s.terms(n), from.near[at(n)], touching_[at(n)], to, by);
      if (s.solids.count > 0 && !is_away(n, to)) to = project_out(s.solids, s.start(n), to, s.clearance(n));
    });
    next_.has_elastic = false;
    measure(s, next_);
    if (next_.over_goal <= most_growth * from.over_goal || next_.over_goal <= 1 || halvings == most_halvings) return;
    length *= 0.5;
  }
}

/// change_ := d with K d = right_ by generalised conjugate residuals (the rows of friction are not symmetric), then +
/// d_c. They break down where an image is orthogonal to the residual: all further images are, too.
int NewtonCloth::solve_linear(const ClothSystem& s) {
  tangent_.multiply(s, freedom_, true, correction_, room_);
  NodeVector& r = right_;
  host_parallel("drench::cloth::newton_right", nodes_, [&](const Index n) {
    auto own = at_node(r, n);
    own -= at_node(room_, n);
    if (!freedom_[at(n)].all) own = (freedom_[at(n)].free * own).eval();
  });
  change_ = correction_;
  stagnates_ = false;
  const double target = std::max(forcing * sums_.norms(r), 0.2 * goal_);
  for (int k = 0; k < most_linear;) {
    if (directions_.size() == at(k)) {
      directions_.emplace_back(r.size());
      images_.emplace_back(r.size());
    }
    NodeVector &z = directions_[at(k)], &q = images_[at(k)];
    tangent_.precondition(freedom_, r, z);
    tangent_.multiply(s, freedom_, true, z, q);
    make_orthogonal(k);
    const double norm = std::sqrt(sums_.dot(q, q));
    if (!(norm > 0)) return k;
    const Real scale = Real(1 / norm), a = Real(sums_.dot(r, q) / norm);
    stagnates_ = double(a) * double(a) <= no_progress * sums_.dot(r, r);
    if (stagnates_) return k;
    host_parallel("drench::cloth::newton_solution", nodes_, [&](const Index n) {
      at_node(q, n) *= scale;
      at_node(z, n) *= scale;
      at_node(change_, n) += a * at_node(z, n);
      at_node(r, n) -= a * at_node(q, n);
    });
    if (++k == most_linear || sums_.norms(r) <= target) return k;
  }
  return most_linear;
}

/// Takes from image k what lies along the images before it, and the same from its direction.
void NewtonCloth::make_orthogonal(int k) {
  if (k == 0) return;
  NodeVector &z = directions_[at(k)], &q = images_[at(k)];
  sums_.dots(images_, k, q, products_);
  for_chunks("drench::cloth::newton_orthogonal", static_cast<Index>(q.size()), [&](const Index begin, const Index end) {
    for (int j = 0; j < k; ++j) {
      const Real a = Real(products_[at(j)]);
      const NodeVector &image = images_[at(j)], &direction = directions_[at(j)];
      for (Index i = begin; i < end; ++i) {
        q[at(i)] -= a * image[at(i)];
        z[at(i)] -= a * direction[at(i)];
      }
    }
  });
}

bool prepare_newton(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, bool pushes_bodies) {
  if constexpr (!on_host) return false;
  if (!solver.newton) solver.newton = std::make_shared<NewtonCloth>(cloth, s);
  solver.newton->prepare(cloth, s, pushes_bodies);
  return true;
}

bool run_newton(ClothSolverWork& solver, const ClothSystem& s, ClothProgress& progress, int most, double tolerance) {
  const bool done = solver.newton->run(std::as_const(solver).displacement, s, progress, most, tolerance);
  restore_newton(solver, s);
  return done;
}

void begin_newton_anew(ClothSolverWork& solver) { solver.newton->begin_anew(); }

void restore_newton(ClothSolverWork& solver, const ClothSystem& s) {
  solver.newton->write_result(s, solver.displacement);
  copy_now(solver.last_displacement, solver.displacement);
}

void run_newton_on_host(const Bodies& bodies, const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s,
                        bool pushes_bodies, ClothProgress& progress, int most, double tolerance) {
  const HostCloth host(bodies, cloth, solver, s);
  if (!solver.newton) solver.newton = std::make_shared<NewtonCloth>(cloth, host.system);
  solver.newton->prepare(cloth, host.system, pushes_bodies);
  solver.newton->run(host.displacement, host.system, progress, most, tolerance);
  solver.newton->write_result(host.system, host.displacement);
  host.write_displacement(solver);
}

}  // namespace drench::kokkos_backend
