#include "watch.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "base/eigen_vec.hpp"
#include "state/film.hpp"
#include "test_ranks.hpp"
#include "watched_energy.hpp"

namespace drench::test {
namespace {

using Eigen::Vector3d;

constexpr double lies_on = 0.1;  // spacings: a particle that a sheet stops ends 0.01 above it, or as far as it was

double volume(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return (b - a).cross(c - a).dot(p - a);
}

Quanta total_of(const HostState& s) {
  return std::accumulate(s.fluid_mass.begin(), s.fluid_mass.end(), Quanta{0}) +
         std::accumulate(s.node_liquid.begin(), s.node_liquid.end(), Quanta{0}) + s.drained + s.evaporated - s.supplied;
}

Quanta solute_of(const HostState& s) {
  return std::accumulate(s.fluid_solute.begin(), s.fluid_solute.end(), Quanta{0}) +
         std::accumulate(s.node_solute.begin(), s.node_solute.end(), Quanta{0}) + s.solute_drained +
         s.solute_deposited - s.solute_supplied;
}

bool any_below_zero(const std::vector<Quanta>& quanta) {
  return std::any_of(quanta.begin(), quanta.end(), [](Quanta q) { return q < 0; });
}

double largest(const std::vector<Vec3>& vectors) {
  double most = 0;
  for (const Vec3& v : vectors) most = std::max(most, to_eigen(v).norm());
  return most;
}

struct Bounds {
  Vec3 lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  void add(const Vec3& x) {
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], x[a]);
      hi[a] = std::max(hi[a], x[a]);
    }
  }
  bool meets(const Bounds& o) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (lo[a] > o.hi[a] || o.lo[a] > hi[a]) return false;
    return true;
  }
};

/// The point of a triangle next to the plane's foot of `p`, by its barycentric coordinates; false where the foot is
/// outside, or farther than `reach` (m).
bool foot(const Vector3d& p, const std::array<Vec3, 3>& corner, double reach, Vector3d& weight) {
  const Vector3d a = to_eigen(corner[0]), u = to_eigen(corner[1]) - a, v = to_eigen(corner[2]) - a, n = u.cross(v);
  const double area = n.squaredNorm();
  if (!(area > 0) || std::abs(n.dot(p - a)) > reach * std::sqrt(area)) return false;
  weight[1] = (p - a).cross(v).dot(n) / area;
  weight[2] = u.cross(p - a).dot(n) / area;
  weight[0] = 1 - weight[1] - weight[2];
  return weight.minCoeff() >= 0;
}

}  // namespace

int crossings(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  const auto at = [](const Vec3& x, const Vec3& y, double t) {
    return Vector3d((1 - t) * to_eigen(x) + t * to_eigen(y));
  };
  const auto f = [&](double t) {
    return volume(at(from, to, t), at(a[0], b[0], t), at(a[1], b[1], t), at(a[2], b[2], t));
  };
  // A cubic through four values: between its extremes it is monotone, so that bisection finds each of its roots.
  const double f0 = f(0), f1 = f(1.0 / 3), f2 = f(2.0 / 3), f3 = f(1);
  const double c1 = 0.5 * (-11 * f0 + 18 * f1 - 9 * f2 + 2 * f3), c2 = 0.5 * (18 * f0 - 45 * f1 + 36 * f2 - 9 * f3),
               c3 = 0.5 * (-9 * f0 + 27 * f1 - 27 * f2 + 9 * f3);
  std::vector<double> ends{0};
  const double root = c2 * c2 - 3 * c1 * c3;
  if (root > 0 && c3 != 0) {
    double extremes[] = {(-c2 - std::sqrt(root)) / (3 * c3), (-c2 + std::sqrt(root)) / (3 * c3)};
    if (extremes[0] > extremes[1]) std::swap(extremes[0], extremes[1]);
    for (const double t : extremes)
      if (t > 0 && t < 1) ends.push_back(t);
  } else if (c3 == 0 && c2 != 0 && -c1 / (2 * c2) > 0 && -c1 / (2 * c2) < 1) {
    ends.push_back(-c1 / (2 * c2));
  }
  ends.push_back(1);
  int count = 0;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    double low = ends[k], high = ends[k + 1];
    const bool rises = f(low) < 0;
    if (rises == (f(high) < 0)) continue;
    for (int n = 0; n < 60; ++n) {
      const double middle = 0.5 * (low + high);
      ((f(middle) < 0) == rises ? low : high) = middle;
    }
    const Vector3d p = at(from, to, low), x = at(a[0], b[0], low), y = at(a[1], b[1], low), z = at(a[2], b[2], low);
    const Vector3d n = (y - x).cross(z - x);
    count += (y - x).cross(p - x).dot(n) > 0 && (z - y).cross(p - y).dot(n) > 0 && (x - z).cross(p - z).dot(n) > 0;
  }
  return count;
}

Watch::Watch(const Model& model, const HostState& start, const Rules& rules)
    : model_(model),
      rules_(rules),
      last_(start),
      most_liquid_(start.node_liquid),
      total_(total_of(start)),
      solute_(solute_of(start)) {
  for (std::size_t n = 0; n < most_liquid_.size(); ++n) {
    if (model.samples.node_capacity.empty()) continue;
    const ClothMaterial& cloth = model.material_of_node(static_cast<Index>(n));
    const double bound =
        std::floor(ceiling_of_node(model, static_cast<Index>(n)) * model.samples.node_capacity[n] / model.quantum);
    most_liquid_[n] = std::max(most_liquid_[n], static_cast<Quanta>(cloth.porous ? bound : 0));
  }
  initial_energy_ = energy_ = mechanical_energy(model, start);
  motion_ = motion_energy(model, start);
}

void Watch::look_at_numbers(const HostState& now, Complaints& wrong) {
  visit_fields(now, [&](std::string_view name, const auto& array) {
    std::size_t bad = 0;
    for (const auto& x : array) {
      using T = std::decay_t<decltype(x)>;
      if constexpr (std::is_same_v<T, double>) {
        bad += !std::isfinite(x);
      } else if constexpr (!std::is_integral_v<T>) {
        for (const double v : x) bad += !std::isfinite(v);
      }
    }
    if (bad > 0) wrong.push_back(fmt::format("{} has {} numbers that are not finite", name, bad));
  });
  const double speed = std::max(largest(now.fluid_velocity), largest(now.node_velocity));
  speed_ = std::max(speed_, speed);
  if (speed > rules_.fastest) wrong.push_back(fmt::format("{} m/s, more than {}", speed, rules_.fastest));
}

void Watch::look_at_masses(const HostState& now, Complaints& wrong) {
  if (total_of(now) != total_) wrong.push_back(fmt::format("the ledger is off by {} quanta", total_of(now) - total_));
  if (solute_of(now) != solute_)
    wrong.push_back(fmt::format("the solute's ledger is off by {} quanta", solute_of(now) - solute_));
  if (any_below_zero(now.fluid_solute) || any_below_zero(now.node_solute)) wrong.push_back("some solute is below 0");
  std::unordered_map<std::int64_t, Quanta> before;
  for (std::size_t i = 0; i < last_.fluid_id.size(); ++i) before[last_.fluid_id[i]] = last_.fluid_mass[i];
  for (std::size_t i = 0; i < now.fluid_id.size(); ++i) {
    const auto old = before.find(now.fluid_id[i]);
    const Quanta mass = now.fluid_mass[i];
    const Quanta least = old == before.end() ? model_.min_quanta : std::min(old->second, model_.min_quanta);
    const Quanta most = std::max(old == before.end() ? Quanta{0} : old->second, model_.max_quanta);
    if (mass < least || mass > most || mass <= 0)
      wrong.push_back(fmt::format("particle {} has {} quanta, not {} to {}", now.fluid_id[i], mass, least, most));
  }
  for (std::size_t n = 0; n < now.node_liquid.size(); ++n) {
    const Quanta mass = now.node_liquid[n];
    // What diffusion takes after emission leaves the buffer as it was until the next step (docs/theory/porous.md, Eq.
    // 12).
    if (mass < 0 || now.node_buffered[n] < 0 || now.node_buffered[n] > std::max(mass, last_.node_liquid[n]))
      wrong.push_back(fmt::format("node {} has {} quanta, {} of them buffered", n, mass, now.node_buffered[n]));
    if (model_.samples.node_capacity.empty()) continue;
    if (model_.samples.node_capacity[n] > 0)
      wet_ = std::max(wet_, static_cast<double>(mass) * model_.quantum / model_.samples.node_capacity[n]);
    if (!rules_.bounded_saturation) continue;
    if (mass > most_liquid_[n])
      wrong.push_back(
          fmt::format("node {} has {} quanta above s_max or what it had before", n, mass - most_liquid_[n]));
    // Where it starts above s_max it may only fall.
    const ClothMaterial& cloth = model_.material_of_node(static_cast<Index>(n));
    const double bound =
        std::floor(ceiling_of_node(model_, static_cast<Index>(n)) * model_.samples.node_capacity[n] / model_.quantum);
    most_liquid_[n] = std::max(static_cast<Quanta>(cloth.porous ? bound : 0), std::min(most_liquid_[n], mass));
  }
}

void Watch::look_at_passage(const HostState& now, const StepReport& report, Complaints& wrong) {
  if (!rules_.passage || model_.mesh.triangle.empty()) return;
  std::unordered_map<std::int64_t, std::size_t> before;
  for (std::size_t i = 0; i < last_.fluid_id.size(); ++i) before[last_.fluid_id[i]] = i;
  const auto corners = [&](const HostState& s, std::size_t t) {
    std::array<Vec3, 3> x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = s.node_position[static_cast<std::size_t>(model_.mesh.triangle[t][k])];
    return x;
  };
  std::int64_t told = rules_.told_passages ? report.tunnelled + report.clamped : 0;
  std::vector<Bounds> boxes(model_.mesh.triangle.size());
  Bounds all;
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const HostState* s : {&std::as_const(last_), &now})
      for (const Vec3& x : corners(*s, t)) boxes[t].add(x);
    all.add(boxes[t].lo);
    all.add(boxes[t].hi);
  }
  for (std::size_t i = 0; i < now.fluid_id.size(); ++i) {
    const auto old = before.find(now.fluid_id[i]);
    if (old == before.end()) continue;
    const Vec3 &from = last_.fluid_position[old->second], &to = now.fluid_position[i];
    Bounds path;
    path.add(from);
    path.add(to);
    if (!path.meets(all)) continue;
    // Does the point of another triangle on which the particle ends pass triangle t?
    const auto pinched = [&](std::size_t t) {
      for (std::size_t o = 0; o < boxes.size(); ++o) {
        Vector3d weight;
        if (o == t || !boxes[o].meets(boxes[t]) ||
            !foot(to_eigen(to), corners(now, o), lies_on * model_.spacing, weight))
          continue;
        const auto point = [&](const HostState& s) {
          const auto x = corners(s, o);
          const Vector3d p = weight[0] * to_eigen(x[0]) + weight[1] * to_eigen(x[1]) + weight[2] * to_eigen(x[2]);
          return Vec3{p[0], p[1], p[2]};
        };
        if (crossings(point(last_), point(now), corners(last_, t), corners(now, t)) % 2 != 0) return true;
      }
      return false;
    };
    for (std::size_t t = 0; t < boxes.size(); ++t) {
      if (!path.meets(boxes[t]) || crossings(from, to, corners(last_, t), corners(now, t)) % 2 == 0) continue;
      if (pinched(t)) {
        ++pinched_;
        continue;
      }
      if (told-- > 0) {
        ++told_;
        break;
      }
      wrong.push_back(fmt::format("particle {} passes triangle {}, from ({}, {}, {}) to ({}, {}, {})", now.fluid_id[i],
                                  t, from[0], from[1], from[2], to[0], to[1], to[2]));
      break;
    }
  }
}

void Watch::look_at_energy(const HostState& now, double dt, const StepReport& report, Complaints& wrong) {
  const EnergyInput in = energy_input(model_, last_, now, dt);
  pin_work_ += in.pins;
  absorbed_ += in.absorbed;
  input_ += in.pins + in.jets - in.drained + in.exchanged;
  motion_ += in.jet_motion;
  weight_ = std::max(weight_, weight(model_, now));
  correction_ = std::max(correction_, correction(model_, now, dt));
  energy_ = mechanical_energy(model_, now);
  if (first_sway_ < 0) first_sway_ = sway(model_, last_, dt);
  const double slack = 0.1 * model_.spacing * weight_ + 1e-3 * motion_ + first_sway_ + sway(model_, now, dt) +
                       correction_ + 1e-12;  // the last: roundings of what rests
  const double counted = rules_.springs ? energy_ : energy_ - elastic_energy(model_, now);
  const double excess = counted - initial_energy_ - input_;
  capped_ = capped_ || !report.density_converged || !report.divergence_converged;
  if (slack > 0) excess_ = std::max(excess_, excess / slack);
  const double allowed = capped_ ? std::max(rules_.energy, rules_.capped_energy) : rules_.energy;
  if (excess > allowed * slack)
    wrong.push_back(fmt::format(
        "{:.4g} J, {:.4g} J more than {:.4g} J at the start and {:.4g} J since; slack {:.4g} J{}", counted, excess,
        initial_energy_, input_, slack, capped_ ? ", after a pressure solve that ended at its cap" : ""));
}

std::vector<std::string> Watch::look(const HostState& now, double dt, const StepReport& report) {
  Complaints wrong;
  look_at_numbers(now, wrong);
  look_at_masses(now, wrong);
  if (wrong.empty()) {  // paths and energies of broken numbers say nothing
    look_at_passage(now, report, wrong);
    look_at_energy(now, dt, report, wrong);
  }
  last_ = now;
  return wrong;
}

WatchedRun::WatchedRun(const std::string& yaml, const Rules& rules,
                       const std::function<void(const Model&, HostState&)>& edit)
    : run_(yaml) {
  if (edit) {
    HostState s = run_.initial();
    edit(run_.model(), s);
    run_.restart(s);
  }
  watch_ = std::make_unique<Watch>(run_.model(), run_.state(), rules);
}

void WatchedRun::steps(int count, const std::function<void(const HostState&, const StepReport&)>& each) {
  go(count, each);
  // For tests/app/over_ranks.sh, which compares runs of these tests.
  static int lots = 0;
  testing::Test::RecordProperty(fmt::format("bits_{}", lots++), fmt::format("{:016x}", bits_of(state())));
}

void WatchedRun::go(int count, const std::function<void(const HostState&, const StepReport&)>& each) {
  for (int n = 0; n < count && stopped_.empty(); ++n, ++steps_) {
    std::vector<std::string> wrong;
    try {
      report_ = run_.step();
      wrong = watch_->look(run_.state(), run_.dt(), report_);
    } catch (const RunFailure& failure) {
      if (watch_->rules().may_stop) {
        stopped_ = failure.what();
        return;
      }
      wrong.push_back(fmt::format("stage {}: {}", name_of(failure.stage), failure.what()));
    }
    for (std::size_t k = 0; k < std::min<std::size_t>(wrong.size(), 5); ++k)
      ADD_FAILURE() << "step " << steps_ << ": " << wrong[k] << " (" << k + 1 << " of " << wrong.size() << ")";
    if (!wrong.empty()) return;
    collisions_ += report_.collisions;
    clamped_ += report_.clamped;
    most_particles_ = std::max(most_particles_, state().fluid_position.size());
    if (each) each(state(), report_);
  }
}

void WatchedRun::print(const char* name) const {
  const HostState& s = state();
  std::printf(
      "%s: %lld steps, %.3f s; at most %zu particles, %zu at the end; %lld stopped at cloth, %lld put back by solids; "
      "fastest %.3g m/s, saturation at most %.4f; energy %.4g to %.4g J, %.2g slacks above its bound at most\n",
      name, static_cast<long long>(steps_), run_.time(), most_particles_, s.fluid_position.size(),
      static_cast<long long>(collisions_), static_cast<long long>(clamped_), watch_->largest_speed(),
      watch_->largest_saturation(), watch_->initial_energy(), watch_->energy(), watch_->energy_excess());
  if (watch_->pinched() > 0)
    std::printf("  %lld times between two sheets that pass each other\n", static_cast<long long>(watch_->pinched()));
  if (watch_->told() > 0) std::printf("  %lld passages that the run told of\n", static_cast<long long>(watch_->told()));
  if (!stopped_.empty()) std::printf("  stopped: %s\n", stopped_.c_str());
  std::fflush(stdout);
}

void keep_particles(HostState& s, std::size_t count) {
  visit_fields(s, [&](std::string_view name, auto& array) {
    if (name.starts_with("fluid_")) array.resize(std::min(count, array.size()));
  });
}

void soak(const Model& m, HostState& s, double saturation) {
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
    s.node_liquid[n] = static_cast<Quanta>(saturation * m.samples.node_capacity[n] / m.quantum);
}

}  // namespace drench::test
