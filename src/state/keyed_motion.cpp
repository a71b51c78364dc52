#include "state/keyed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "state/deforming_body.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

Vec3 sum(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

Vec3 scaled(double by, const Vec3& v) { return to_vec3(by * to_eigen(v)); }

/// For how long a commanded motion has gone on at `time`, s.
double under_way(const CommandedMotion& c, double time) { return std::clamp(time, c.start, c.end) - c.start; }
bool is_under_way(const CommandedMotion& c, double time) { return time >= c.start && time < c.end; }

/// The fastest that the centre moves between two times, m/s.
double fastest_shift(const Body& body, double from, double to) {
  if (body.commanded)
    return under_way(body.command, to) > under_way(body.command, from) ? to_eigen(body.command.velocity).norm() : 0;
  return body.velocity.largest(from, to) + body.path.largest_derivative(from, to);
}

Eigen::Quaterniond to_quaternion(const Quaternion& q) { return {q[0], q[1], q[2], q[3]}; }

/// The number of the last turn that is not after `time`; the first, if all are.
std::size_t turn_before(const Body& body, double time) {
  const auto after = std::upper_bound(body.turns.begin(), body.turns.end(), time,
                                      [](double t, const Key<Quaternion>& key) { return t < key.time; });
  return after == body.turns.begin() ? 0 : static_cast<std::size_t>(after - body.turns.begin()) - 1;
}

Eigen::Quaterniond between_turns(const Body& body, double time) {
  const std::size_t k = turn_before(body, time);
  const Key<Quaternion>& first = body.turns[k];
  if (time <= first.time || k + 1 == body.turns.size()) return to_quaternion(first.value);
  const Key<Quaternion>& last = body.turns[k + 1];
  return to_quaternion(first.value).slerp((time - first.time) / (last.time - first.time), to_quaternion(last.value));
}

/// The steady angular velocity (rad/s) that turns one into the other in `time`, s, the short way.
Vec3 rotation_vector(const Eigen::Quaterniond& first, const Eigen::Quaterniond& last, double time) {
  const Eigen::AngleAxisd turn(last * first.conjugate());
  const double angle = turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
  return to_vec3(angle / time * turn.axis());
}

}  // namespace

Vec3 way_at(const Body& body, double time) {
  if (body.commanded) return sum(body.command.moved, scaled(under_way(body.command, time), body.command.velocity));
  return sum(body.velocity.integral(0, time), body.path.at(time));
}

Vec3 velocity_at(const Body& body, double time) {
  if (body.commanded) return is_under_way(body.command, time) ? body.command.velocity : Vec3{0, 0, 0};
  return sum(body.velocity.at(time), body.path.derivative(time));
}

Quaternion orientation_at(const Body& body, double time) {
  Eigen::Quaterniond q;
  if (body.commanded) {
    const Eigen::Vector3d turn = under_way(body.command, time) * to_eigen(body.command.spin);
    q = to_quaternion(body.command.orientation);
    if (turn.norm() > 0) q = (Eigen::AngleAxisd(turn.norm(), turn.normalized()) * q).normalized();
  } else if (body.turns.empty()) {
    q = Eigen::AngleAxisd(std::remainder(body.spin_rate.integral(0, time), 4 * std::numbers::pi),
                          to_eigen(body.spin_axis));
  } else {
    q = between_turns(body, time);
  }
  return {q.w(), q.x(), q.y(), q.z()};
}

Vec3 carried_point(const Body& body, const Vec3& arm, double time) {
  return to_vec3(to_eigen(body.center) + to_eigen(way_at(body, time)) +
                 to_quaternion(orientation_at(body, time)) * to_eigen(arm));
}

Vec3 arm_of_point(const Body& body, const Vec3& x, double time) {
  return to_vec3(to_quaternion(orientation_at(body, time)).conjugate() *
                 (to_eigen(x) - to_eigen(body.center) - to_eigen(way_at(body, time))));
}

Vec3 spin_between(const Body& body, double from, double to) {
  if (body.commanded) {
    const CommandedMotion& c = body.command;
    if (!(from < to)) return is_under_way(c, from) ? c.spin : Vec3{0, 0, 0};
    return scaled((under_way(c, to) - under_way(c, from)) / (to - from), c.spin);
  }
  if (body.turns.empty()) {
    const double rate = from < to ? body.spin_rate.integral(from, to) / (to - from) : body.spin_rate.at(from);
    return to_vec3(rate * to_eigen(body.spin_axis));
  }
  if (from < to) return rotation_vector(between_turns(body, from), between_turns(body, to), to - from);
  const std::size_t k = turn_before(body, from);
  if (from < body.turns.front().time || k + 1 == body.turns.size()) return {0, 0, 0};
  return rotation_vector(to_quaternion(body.turns[k].value), to_quaternion(body.turns[k + 1].value),
                         body.turns[k + 1].time - body.turns[k].time);
}

double fastest_turn(const Body& body, double from, double to) {
  if (body.commanded)
    return under_way(body.command, to) > under_way(body.command, from) ? to_eigen(body.command.spin).norm() : 0;
  return body.turns.empty() ? body.spin_rate.largest(from, to) : body.turn_rate;
}

std::array<Vec3, 2> bounds_of_way(const Body& body, double duration) {
  constexpr double all = 1e9;  // m: far beyond any scene's coordinates; nobody knows what a program will command
  if (body.commanded) return {Vec3{-all, -all, -all}, Vec3{all, all, all}};
  std::vector<double> times{0, duration};
  for (const Keyed<Vec3>* keyed : {&body.velocity, &body.path})
    for (const Key<Vec3>& key : keyed->keys())
      if (key.time > 0 && key.time < duration) times.push_back(key.time);
  std::sort(times.begin(), times.end());
  std::array<Vec3, 2> bounds{};
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Vec3 here = way_at(body, times[k]);
    // Between two of the times the velocity may turn: then it comes no farther than its largest takes it.
    const double beyond = k == 0 ? 0 : (times[k] - times[k - 1]) * body.velocity.largest(times[k - 1], times[k]);
    const Vec3 before = way_at(body, k == 0 ? 0 : times[k - 1]);
    for (std::size_t a = 0; a < 3; ++a) {
      const bool turns = k > 0 && body.velocity.at(times[k - 1])[a] * body.velocity.at(times[k])[a] < 0;
      const double more = turns ? beyond : 0;
      bounds[0][a] = std::min(bounds[0][a], std::min(here[a], before[a]) - more);
      bounds[1][a] = std::max(bounds[1][a], std::max(here[a], before[a]) + more);
    }
  }
  return bounds;
}

double fastest_by_keys(const Model& model, double from, double to) {
  double fastest = 0;
  for (const Body& body : model.bodies)
    if (body.has_keys())
      fastest = std::max(fastest,
                         fastest_shift(body, from, to) + (body.deforms() ? fastest_point(body.shape, from, to)
                                                                         : fastest_turn(body, from, to) * body.reach));
  for (const PinMotion& pin : model.pin_motions) {
    if (pin.body >= 0) {
      const Body& body = model.bodies[static_cast<std::size_t>(pin.body)];
      fastest = std::max(fastest, fastest_shift(body, from, to) + fastest_turn(body, from, to) * pin.reach);
      continue;
    }
    const double begin = std::clamp(from, pin.start, pin.end), end = std::clamp(to, pin.start, pin.end);
    if (pin.has_keys() && begin < end)
      fastest = std::max(fastest, pin.velocity.largest(begin, end) + pin.path.largest_derivative(begin, end) +
                                      pin.rate.largest(begin, end) * pin.reach);
  }
  for (const Jet& jet : model.jets)
    if ((jet.has_keys() || jet.mouth) && from < jet.scene.end && to > jet.scene.start)
      fastest = std::max(fastest, fastest_leaving(jet, from, to));
  return fastest;
}

}  // namespace drench
