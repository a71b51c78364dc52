// Stage jets (src/stages/jets.hpp).

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common.hpp"
#include "state/needed_fields.hpp"
#include "state/nozzle.hpp"

namespace drench::reference {

using Eigen::Vector3d;

namespace {

/// Eqs. 30, 31: the liquid comes out as a plug, whose axis turns as keys say.
void let_go_by_keys(ReferenceState& state, const Jet& jet, std::int64_t& q, double now) {
  if (now <= jet.scene.start) return;
  const double out = jet.speed.integral(jet.scene.start, std::min(now, jet.scene.end));
  const Vector3d axis = vec(jet.aim.at(now)).normalized();
  const auto turn = turn_between(vec(jet.aim.plain()), axis);
  for (; (static_cast<double>(q) + 0.5) * jet.advance <= out; ++q) {
    const double ahead = out - (static_cast<double>(q) + 0.5) * jet.advance;
    const Vec3& offset = jet.offsets[static_cast<std::size_t>(q) % jet.offsets.size()];
    append_particle(state.s, state.model,
                    {arr(vec(jet.scene.center) + turn * vec(offset) + ahead * axis), arr(jet.speed.at(now) * axis),
                     jet.mass, Origin::jet, jet.solute});
    state.s.supplied += jet.mass;
    state.s.solute_supplied += jet.solute;
  }
}

/// Of a mouth that moves or is a mesh: what the model has in closed form is looked for anew here, in small steps.
class MovingMouth {
 public:
  MovingMouth(const Jet& jet) : jet_(jet), mouth_(*jet.mouth) {}

  /// m³ that have come out: area times speed, by Boole's rule between the keys of either.
  double volume(double time) const {
    const double end = std::min(time, jet_.scene.end);
    std::vector<double> times{jet_.scene.start, end};
    for (const Keyed<double>* keyed : {&jet_.speed, &mouth_.area})
      for (const Key<double>& key : keyed->keys())
        if (key.time > jet_.scene.start && key.time < end) times.push_back(key.time);
    std::ranges::sort(times);
    double sum = 0;
    for (std::size_t k = 1; k < times.size() && end > jet_.scene.start; ++k) {
      const double from = times[k - 1], length = times[k] - from;
      // At its ends a speed with steps may have the value of the neighbouring piece.
      const double edge = 1e-12 * length;
      const auto flow = [&](double s) {
        const double at = from + std::clamp(s * length, edge, length - edge);
        return mouth_.area.at(at) * jet_.speed.at(at);
      };
      sum += length / 90 * (7 * (flow(0) + flow(1)) + 32 * (flow(0.25) + flow(0.75)) + 12 * flow(0.5));
    }
    return sum;
  }

  /// When so much has come out, by halving.
  double time_of(double asked, double low, double high) const {
    for (int k = 0; k < 100; ++k) {
      const double middle = 0.5 * (low + high);
      (volume(middle) < asked ? low : high) = middle;
    }
    return high;
  }

  /// Particle q, which leaves at a time.
  std::pair<Vector3d, Vector3d> leaving(std::int64_t q, double time) const {
    const std::size_t p = point_of(q, time);
    const double speed = (mouth_.directions.empty() ? 1 : faces_speed_factor) * jet_.speed.at(time);
    if (!mouth_.points.empty()) {
      const auto [file, part] = file_at(time);
      const Vector3d first = vec(mouth_.points[file][p]);
      Vector3d velocity = Vector3d::Zero(), x = first, along = axis(time);
      if (!mouth_.directions.empty()) along = vec(mouth_.directions[file][p]);
      if (file + 1 < mouth_.points.size()) {
        const Vector3d step = vec(mouth_.points[file + 1][p]) - first;
        if (time >= mouth_.time.front()) velocity = step / (mouth_.time[file + 1] - mouth_.time[file]);
        x += part * step;
        if (!mouth_.directions.empty())
          along = ((1 - part) * along + part * vec(mouth_.directions[file + 1][p])).normalized();
      }
      return {x, velocity + speed * along};
    }
    const PinMotion& m = mouth_.motion;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(m.rate.integral(0, time), vec(m.axis)).toRotationMatrix();
    Vector3d offset = vec(jet_.offsets[p]), along = axis(time);
    if (jet_.aim.has_keys()) offset = turn_between(vec(jet_.aim.plain()), along) * offset;
    if (!mouth_.directions.empty()) along = vec(mouth_.directions.front()[p]);
    if (mouth_.cone) along = spread(along, q);
    const Vector3d centre = vec(m.center) + vec(m.velocity.integral(0, time)) + vec(m.path.at(time)),
                   x = centre + turn * (vec(jet_.scene.center) + offset - vec(m.center)),
                   spin = m.rate.at(time) * vec(m.axis);
    return {x,
            vec(m.velocity.at(time)) + vec(m.path.derivative(time)) + spin.cross(x - centre) + speed * (turn * along)};
  }

 private:
  /// Particle q's direction in the cone of a spray: on the part of the unit sphere from the pole to the edge, areas are
  /// in proportion to heights.
  Vector3d spread(const Vector3d& along, std::int64_t q) const {
    const auto part_of = [&](double step) {
      const double x = 0.5 + step * static_cast<double>(q);
      return x - std::floor(x);
    };
    const double height = (1 - mouth_.cone->cosine) * part_of(roberts[0]),
                 turn = 2 * std::numbers::pi * part_of(roberts[1]), out = std::sqrt(height * (2 - height));
    return (1 - height) * along +
           out * (std::cos(turn) * vec(mouth_.cone->across[0]) + std::sin(turn) * vec(mouth_.cone->across[1]));
  }

  Vector3d axis(double time) const { return vec(jet_.aim.at(time)).normalized(); }

  std::pair<std::size_t, double> file_at(double time) const {
    std::size_t file = 0;
    while (file + 1 < mouth_.time.size() && mouth_.time[file + 1] <= time) ++file;
    if (file + 1 == mouth_.time.size()) return {file, 0.0};
    return {file, std::max(0.0, time - mouth_.time[file]) / (mouth_.time[file + 1] - mouth_.time[file])};
  }

  /// The first point up to which more of the flow leaves than before a place in particle q's part of it, another in
  /// each round.
  std::size_t point_of(std::int64_t q, double time) const {
    const std::size_t n = mouth_.points.empty() ? jet_.offsets.size() : mouth_.points.front().size();
    const std::size_t number = static_cast<std::size_t>(q) % n * static_cast<std::size_t>(mouth_.stride) % n;
    if (mouth_.flow.empty()) return number;
    std::vector<double> sums = mouth_.flow.front();
    if (!mouth_.points.empty()) {
      const auto [file, part] = file_at(time);
      sums = mouth_.flow[file];
      for (std::size_t p = 0; p < n && file + 1 < mouth_.flow.size(); ++p)
        sums[p] += part * (mouth_.flow[file + 1][p] - sums[p]);
    }
    const double round = std::floor(static_cast<double>(q) / static_cast<double>(n)),
                 shift = 0.5 + round * (0.5 * std::sqrt(5.0) - 0.5);
    const double asked =
        (static_cast<double>(number) + shift - std::floor(shift)) / static_cast<double>(n) * sums.back();
    return static_cast<std::size_t>(std::ranges::find_if(sums, [&](double sum) { return sum > asked; }) - sums.begin());
  }

  const Jet& jet_;
  const Mouth& mouth_;
};

/// Eqs. 29b to 29f.
void let_go_moving(ReferenceState& state, const Jet& jet, std::int64_t& q, const StepInfo& info) {
  const MovingMouth mouth(jet);
  const double now = info.time + info.dt, volume = std::pow(state.model.spacing, 3), out = mouth.volume(now);
  for (; (static_cast<double>(q) + 0.5) * volume <= out; ++q) {
    const double time = mouth.time_of((static_cast<double>(q) + 0.5) * volume, info.time, now);
    const auto [x, v] = mouth.leaving(q, time);
    append_particle(state.s, state.model, {arr(x + (now - time) * v), arr(v), jet.mass, Origin::mouth, jet.solute});
    state.s.supplied += jet.mass;
    state.s.solute_supplied += jet.solute;
  }
}

}  // namespace

void jets(ReferenceState& state, const StepInfo& info, StepReport&) {
  HostState& s = state.s;
  const double now = info.time + info.dt;
  s.jet_particles.resize(state.model.jets.size(), 0);
  for (std::size_t k = 0; k < state.model.jets.size(); ++k) {
    const Jet& jet = state.model.jets[k];
    if (jet.mouth) {
      let_go_moving(state, jet, s.jet_particles[k], info);
      continue;
    }
    if (jet.has_keys()) {
      let_go_by_keys(state, jet, s.jet_particles[k], now);
      continue;
    }
    const Vec3& velocity = jet.scene.velocity.plain();
    for (std::int64_t& q = s.jet_particles[k];; ++q) {
      const double leaves = jet.scene.start + (static_cast<double>(q) + 0.5) * jet.interval;
      if (leaves > now || leaves >= jet.scene.end) break;
      const Vector3d travelled = vec(velocity) * (now - leaves);
      const Vec3& offset = jet.offsets[static_cast<std::size_t>(q) % jet.offsets.size()];
      append_particle(
          s, state.model,
          {arr(vec(jet.scene.center) + vec(offset) + travelled), velocity, jet.mass, Origin::jet, jet.solute});
      s.supplied += jet.mass;
      s.solute_supplied += jet.solute;
    }
  }
}

}  // namespace drench::reference
