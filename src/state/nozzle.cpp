#include "state/nozzle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "state/file_times.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

double mixed(double first, double last, double part) { return first + part * (last - first); }

/// What the points up to p emit, 1.
double flow_of_points(const Mouth& mouth, const FilePart& at, std::size_t p) {
  const double first = mouth.flow[at.first][p];
  return at.part > 0 ? mixed(first, mouth.flow[at.last][p], at.part) : first;
}

/// The point that particle k leaves from. Points that emit alike take turns, in an order in which neighbours are far
/// apart in time; of others, each has its part of the flow in the mean of the rounds.
std::size_t point_of(const Mouth& mouth, std::size_t points, std::int64_t k, double time) {
  const auto n = static_cast<std::int64_t>(points);
  const std::int64_t part = k % n * mouth.stride % n;
  if (mouth.flow.empty()) return static_cast<std::size_t>(part);
  const FilePart at = files_at(mouth.time, time);
  const double within = std::fmod(0.5 + static_cast<double>(k / n) / std::numbers::phi, 1.0);
  const double asked =
      (static_cast<double>(part) + within) / static_cast<double>(n) * flow_of_points(mouth, at, points - 1);
  std::size_t low = 0, high = points - 1;  // the first whose flow is above what is asked for
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (flow_of_points(mouth, at, middle) > asked)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

Eigen::Quaterniond turn_at(const PinMotion& motion, double time) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(motion.rate.integral(0, time), to_eigen(motion.axis)));
}

Vector3d way_at(const PinMotion& motion, double time) {
  return to_eigen(motion.velocity.integral(0, time)) + to_eigen(motion.path.at(time));
}

/// The unit axis of a nozzle before its motion.
Vector3d axis_at(const Jet& jet, double time) { return to_eigen(jet.aim.at(time)).normalized(); }

/// Where a point of a mouth is that moves as a whole, and its velocity.
Leaving carried(const Jet& jet, const Vec3& offset, double time) {
  const PinMotion& motion = jet.mouth->motion;
  Vector3d o = to_eigen(offset);
  if (jet.aim.has_keys()) o = shortest_turn(to_eigen(jet.aim.plain()), axis_at(jet, time)) * o;
  const Vector3d arm = turn_at(motion, time) * (to_eigen(jet.scene.center) - to_eigen(motion.center) + o);
  return {to_vec3(to_eigen(motion.center) + way_at(motion, time) + arm),
          to_vec3(to_eigen(motion.velocity.at(time)) + to_eigen(motion.path.derivative(time)) +
                  motion.rate.at(time) * to_eigen(motion.axis).cross(arm))};
}

/// The same of a point of a sequence of files.
Leaving carried_by_files(const Mouth& mouth, std::size_t p, double time) {
  const FilePart at = files_at(mouth.time, time);
  const Vector3d first = to_eigen(mouth.points[at.first][p]), last = to_eigen(mouth.points[at.last][p]);
  const double between = at.first == at.last ? 1 : mouth.time[at.last] - mouth.time[at.first];
  return {to_vec3(first + at.part * (last - first)), to_vec3((last - first) / between)};
}

Leaving point_at(const Jet& jet, std::size_t p, double time) {
  return jet.mouth->points.empty() ? carried(jet, jet.offsets[p], time) : carried_by_files(*jet.mouth, p, time);
}

/// Unit: where particle k of a spray goes before the motion of the mouth. Equal parts of the cone's solid angle have
/// equally many.
Vector3d direction_in_cone(const Jet& jet, const Mouth::Cone& cone, std::int64_t k) {
  const auto number = static_cast<double>(k);
  const double part = std::fmod(0.5 + roberts[0] * number, 1.0), turn = std::fmod(0.5 + roberts[1] * number, 1.0),
               cosine = 1 - part * (1 - cone.cosine), sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)),
               angle = 2 * std::numbers::pi * turn;
  return cosine * to_eigen(jet.aim.plain()) +
         sine * (std::cos(angle) * to_eigen(cone.across[0]) + std::sin(angle) * to_eigen(cone.across[1]));
}

/// Unit: where particle k goes, which leaves from point p, seen from the mouth.
Vector3d direction_at(const Jet& jet, std::size_t p, std::int64_t k, double time) {
  const Mouth& mouth = *jet.mouth;
  if (mouth.cone) return turn_at(mouth.motion, time) * direction_in_cone(jet, *mouth.cone, k);
  if (mouth.directions.empty()) return turn_at(mouth.motion, time) * axis_at(jet, time);
  if (mouth.points.empty()) return turn_at(mouth.motion, time) * to_eigen(mouth.directions[0][p]);
  const FilePart at = files_at(mouth.time, time);
  const Vector3d first = to_eigen(mouth.directions[at.first][p]), last = to_eigen(mouth.directions[at.last][p]);
  const Vector3d between = first + at.part * (last - first);
  return between.norm() > 1e-6 ? between.normalized() : first;  // they are opposite
}

/// Of area · speed over a time in which both are polynomials of degree 3 and 1: three points are exact to degree 5.
double gauss(const Jet& jet, double from, double to) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from), away = std::sqrt(0.6) * half;
  return half * (8 * flow_at(jet, middle) + 5 * (flow_at(jet, middle - away) + flow_at(jet, middle + away))) / 9;
}

}  // namespace

Mouth::Volumes volumes_at_keys(const Jet& jet) {
  std::vector<double> times{jet.scene.start};
  for (const Keyed<double>* keyed : {&jet.speed, &jet.mouth->area})
    for (const Key<double>& key : keyed->keys())
      if (key.time > jet.scene.start) times.push_back(key.time);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  Mouth::Volumes volumes{std::move(times), {0.0}};
  for (std::size_t k = 1; k < volumes.time.size(); ++k)
    volumes.out.push_back(volumes.out.back() + gauss(jet, volumes.time[k - 1], volumes.time[k]));
  return volumes;
}

double flow_at(const Jet& jet, double time) { return jet.mouth->area.at(time) * jet.speed.at(time); }

double volume_out(const Jet& jet, double time) {
  const auto& [times, out] = jet.mouth->volumes;
  const double until = std::min(time, jet.scene.end);
  if (!(until > times.front())) return 0;
  const auto k = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), until) - times.begin()) - 1;
  return out[k] + gauss(jet, times[k], until);
}

double time_of_volume(const Jet& jet, double volume, double from, double to) {
  // Newton's method, halving where that leaves the bracket.
  double low = from, high = std::min(to, jet.scene.end), time = 0.5 * (low + high);
  for (int round = 0; round < 200; ++round) {
    const double missing = volume - volume_out(jet, time), flow = flow_at(jet, time);
    (missing > 0 ? low : high) = time;
    double next = flow > 0 ? time + missing / flow : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool found = std::abs(next - time) <= 2 * std::numeric_limits<double>::epsilon() * std::abs(high);
    time = next;
    if (found) break;
  }
  return time;
}

Leaving leaving_particle(const Jet& jet, std::int64_t k, double time) {
  const std::size_t points = jet.mouth->points.empty() ? jet.offsets.size() : jet.mouth->points.front().size(),
                    p = point_of(*jet.mouth, points, k, time);
  Leaving particle = point_at(jet, p, time);
  const double factor = jet.mouth->directions.empty() ? 1 : faces_speed_factor;
  particle.velocity =
      to_vec3(to_eigen(particle.velocity) + factor * jet.speed.at(time) * direction_at(jet, p, k, time));
  return particle;
}

Vec3 center_of_mouth(const Jet& jet, double time) { return carried(jet, {0, 0, 0}, time).position; }

std::vector<Vec3> mouth_at(const Jet& jet, double time) {
  std::vector<Vec3> points;
  if (!jet.mouth) {
    for (const Vec3& offset : jet.offsets) points.push_back(to_vec3(to_eigen(jet.scene.center) + to_eigen(offset)));
    return points;
  }
  const std::size_t count = jet.mouth->points.empty() ? jet.offsets.size() : jet.mouth->points.front().size();
  for (std::size_t p = 0; p < count; ++p) points.push_back(point_at(jet, p, time).position);
  return points;
}

std::vector<double> times_of_mouth(const Jet& jet, double end) {
  constexpr int looks = 16;
  const double last = std::min(jet.scene.end, end);
  if (!jet.mouth || !jet.mouth->moves || !(last > jet.scene.start)) return {jet.scene.start};
  std::vector<double> times;
  for (int k = 0; k <= looks; ++k) times.push_back(mixed(jet.scene.start, last, double(k) / looks));
  return times;
}

double fastest_leaving(const Jet& jet, double from, double to) {
  if (!jet.mouth) return jet.has_keys() ? jet.speed.largest(from, to) : jet.scene.velocity.largest();
  const PinMotion& motion = jet.mouth->motion;
  return faces_speed_factor * jet.speed.largest(from, to) + motion.velocity.largest(from, to) +
         motion.path.largest_derivative(from, to) + motion.rate.largest(from, to) * motion.reach +
         jet.mouth->fastest_file;
}

double fastest_leaving(const Jet& jet) {
  if (!jet.mouth) return jet.scene.velocity.largest();
  const PinMotion& motion = jet.mouth->motion;
  return faces_speed_factor * jet.speed.largest() + motion.velocity.largest() + motion.path.largest_derivative() +
         motion.rate.largest() * motion.reach + jet.mouth->fastest_file;
}

}  // namespace drench
