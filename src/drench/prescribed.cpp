#include "drench/prescribed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "base/eigen_vec.hpp"
#include "pipeline/failure.hpp"
#include "scene/describe.hpp"
#include "scene/scalars.hpp"
#include "setup/emitters.hpp"
#include "state/keyed_motion.hpp"

namespace drench {
namespace {

/// In the range that a scene has for it.
void require_within(const char* name, const Vec3& v, const std::string& range, const char* unit) {
  if (!std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument(fmt::format("{}: ({}, {}, {}) are not finite", name, v[0], v[1], v[2]));
  const Range allowed = parse_range(range);
  if (!std::all_of(v.begin(), v.end(), [&](double x) { return allowed.contains(x); }))
    throw std::invalid_argument(
        fmt::format("{}: ({:g}, {:g}, {:g}) {}; allowed: {}", name, v[0], v[1], v[2], unit, range));
}

/// The motion as it has come by `time`, as the beginning of another one.
PinMotion continued(const PinMotion& m, const Vec3& velocity, double time) {
  const double until = std::clamp(time, m.start, m.end);
  const auto& q = m.rotated;
  const Eigen::Quaterniond before(q[0], q[1], q[2], q[3]);
  const Eigen::Quaterniond now =
      (Eigen::AngleAxisd(m.rate.integral(m.start, until), to_eigen(m.axis)) * before).normalized();
  PinMotion next = m;
  next.offset =
      to_vec3(to_eigen(m.offset) + to_eigen(m.velocity.integral(m.start, until)) + to_eigen(m.path.at(until)));
  next.rotated = {now.w(), now.x(), now.y(), now.z()};
  if (m.rate.is_zero()) next.rotated = m.rotated;
  next.velocity = velocity;
  next.rate = 0.0;
  next.path = Vec3{0, 0, 0};
  next.start = time;
  next.end = std::numeric_limits<double>::infinity();
  return next;
}

/// Adds a motion that has not moved yet.
Index add_motion(Model& m, const std::vector<Index>& nodes) {
  m.mesh.pin_motion.resize(m.mesh.rest_position.size(), -1);
  const auto motion = static_cast<Index>(m.pin_motions.size());
  for (const Index n : nodes) m.mesh.pin_motion[static_cast<std::size_t>(n)] = motion;
  m.pin_motions.emplace_back();
  return motion;
}

/// A cloth that moves and has these nodes, numbered within it from 0.
const ClothMaterial& cloth_to_hold(const Model& m, Index cloth, const std::vector<Index>& nodes) {
  const ClothMaterial& range = cloth_numbered(m, cloth);
  if (!range.dynamics) throw std::invalid_argument(fmt::format("cloth {} does not move: its dynamics is false", cloth));
  for (const Index k : nodes)
    if (k < 0 || k >= range.node_count)
      throw std::invalid_argument(
          fmt::format("cloth {} has no node {}; allowed: 0 to {}", cloth, k, range.node_count - 1));
  return range;
}

/// Removes motions that no node has any more: attaching again and again leaves them behind.
void drop_unused_motions(Model& m) {
  std::vector<Index> number(m.pin_motions.size(), -1);
  for (const Index motion : m.mesh.pin_motion)
    if (motion >= 0) number[static_cast<std::size_t>(motion)] = 0;
  std::vector<PinMotion> used;
  for (std::size_t k = 0; k < number.size(); ++k) {
    if (number[k] < 0) continue;
    number[k] = static_cast<Index>(used.size());
    used.push_back(std::move(m.pin_motions[k]));
  }
  m.pin_motions = std::move(used);
  for (Index& motion : m.mesh.pin_motion)
    if (motion >= 0) motion = number[static_cast<std::size_t>(motion)];
}

/// The jet with another scene, going on from what it has let go by `time`.
Jet continued(const Model& m, Jet jet, JetScene next, double time, const std::string& name) {
  const double let_go = jet.has_keys()
                            ? jet.out(time) / jet.advance
                            : std::max(0.0, (std::min(time, jet.scene.end) - jet.scene.start) / jet.interval);
  jet = make_jet(m, next, name);
  if (time > next.start) jet.scene.start = time - let_go * jet.interval;
  return jet;
}

/// A plain value's numbers; keys are the scene's, and only whether they still hold is told.
template <class Value, class Visitor>
void visit_keyed(Value& value, Visitor&& visit) {
  double keys = value.has_keys() ? 1 : 0;
  auto plain = value.plain();
  visit(keys);
  if constexpr (std::is_same_v<decltype(plain), double>)
    visit(plain);
  else
    for (double& x : plain) visit(x);
  if constexpr (!std::is_const_v<Value>)
    if (keys == 0) value = plain;
}

/// Calls visit(number) for every number of what can have changed, in one order, for both directions.
template <class P, class Visitor>
void visit_numbers(P& p, Visitor&& visit) {
  const auto all = [&](auto& values) {
    for (auto& value : values) visit(value);
  };
  for (auto& m : p.pin_motions) {
    for (auto* v : {&m.axis, &m.center, &m.offset}) all(*v);
    all(m.rotated);
    for (auto* v : {&m.start, &m.end, &m.release}) visit(*v);
    visit_keyed(m.velocity, visit);
    visit_keyed(m.path, visit);
    visit_keyed(m.rate, visit);
    double body = m.body;
    visit(body);
    if constexpr (!std::is_const_v<P>) m.body = static_cast<Index>(body);
    visit(m.reach);
  }
  for (auto& j : p.jets) {
    all(j.scene.center);
    visit_keyed(j.scene.velocity, visit);
    for (auto* v : {&j.scene.start, &j.scene.end}) visit(*v);
  }
  visit_keyed(p.wind.velocity, visit);
  visit(p.fastest_before);
  for (auto& b : p.bodies) {
    for (auto* v : {&b.motion.moved, &b.motion.velocity, &b.motion.spin, &b.force, &b.torque}) all(*v);
    all(b.motion.orientation);
    for (auto* v : {&b.motion.start, &b.motion.end}) visit(*v);
  }
  for (auto& speed : p.motors) visit_keyed(speed, visit);
}

}  // namespace

Prescribed prescribed_of(const Model& m) {
  Prescribed p{m.pin_motions, m.mesh.pin_motion, m.mesh.pinned, m.jets, m.scene.wind, {}, {}, m.fastest_before};
  for (const Joint& j : m.joints) p.motors.push_back(j.speed);
  for (const Body& b : m.bodies) p.bodies.push_back({b.command, b.applied_force, b.applied_torque});
  return p;
}

void prescribe(Model& m, const Prescribed& p) {
  m.pin_motions = p.pin_motions;
  m.mesh.pin_motion = p.pin_motion;
  m.mesh.pinned = p.pinned;
  m.jets = p.jets;
  m.scene.wind = p.wind;
  m.fastest_before = p.fastest_before;
  for (std::size_t k = 0; k < m.joints.size(); ++k) m.joints[k].speed = p.motors[k];
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    m.bodies[b].command = p.bodies[b].motion;
    m.bodies[b].applied_force = p.bodies[b].force;
    m.bodies[b].applied_torque = p.bodies[b].torque;
  }
}

const ClothMaterial& cloth_numbered(const Model& m, Index cloth) {
  if (cloth < 0 || cloth >= std::ssize(m.cloths))
    throw std::invalid_argument(fmt::format("there is no cloth {}; the scene has {}", cloth, m.cloths.size()));
  return m.cloths[static_cast<std::size_t>(cloth)];
}

std::vector<Index> nodes_of_pin(const Model& m, Index cloth, Index number) {
  const ClothMaterial& range = cloth_numbered(m, cloth);
  const std::vector<PinScene>& pins = m.scene.cloths[static_cast<std::size_t>(cloth)].pins;
  if (number < 0 || number >= std::ssize(pins))
    throw std::invalid_argument(fmt::format("cloth {} has no pin {}; it has {}", cloth, number, pins.size()));
  std::vector<Index> nodes;
  for (Index n = range.first_node; n < range.first_node + range.node_count; ++n)
    if (m.mesh.pin_entry[static_cast<std::size_t>(n)] == number) nodes.push_back(n);
  if (nodes.empty())
    throw std::invalid_argument(fmt::format("pin {} of cloth {} has no nodes of its own", number, cloth));
  return nodes;
}

void change_pin_velocity(Model& m, Index cloth, Index number, const Vec3& velocity, double time) {
  require_within("the velocity of a pin", velocity, speed_range, "m/s");
  const std::vector<Index> nodes = nodes_of_pin(m, cloth, number);
  if (!cloth_numbered(m, cloth).dynamics)
    throw std::invalid_argument(fmt::format("cloth {} does not move: its dynamics is false", cloth));
  if (!m.scene.cloths[static_cast<std::size_t>(cloth)].pins[static_cast<std::size_t>(number)].sequence.files.empty())
    throw std::invalid_argument(fmt::format("pin {} of cloth {} follows a sequence of files", number, cloth));
  if (!m.scene.cloths[static_cast<std::size_t>(cloth)].pins[static_cast<std::size_t>(number)].body.empty())
    throw std::invalid_argument(fmt::format("pin {} of cloth {} follows a body", number, cloth));
  m.fastest_before = fastest_prescribed(m);
  Index motion = m.mesh.pin_motion.empty() ? -1 : m.mesh.pin_motion[static_cast<std::size_t>(nodes.front())];
  if (motion < 0) motion = add_motion(m, nodes);
  PinMotion& pin = m.pin_motions[static_cast<std::size_t>(motion)];
  pin = continued(pin, velocity, time);
}

void attach_nodes(Model& m, Index cloth, const std::vector<Index>& nodes, Index number,
                  const std::vector<Vec3>& position, double time) {
  const ClothMaterial& range = cloth_to_hold(m, cloth, nodes);
  const Body& body = body_numbered(m, number);
  if (body.dynamic || body.deforms())
    throw std::invalid_argument(fmt::format(
        "nodes cannot be attached to body {}, which is dynamic or changes its shape; allowed: bodies that the scene or "
        "commands move",
        number));
  m.fastest_before = fastest_prescribed(m);
  m.mesh.pin_motion.resize(m.mesh.rest_position.size(), -1);
  for (const Index k : nodes) {
    const auto n = static_cast<std::size_t>(range.first_node + k);
    const PinMotion* own =
        m.mesh.pin_motion[n] < 0 ? nullptr : &m.pin_motions[static_cast<std::size_t>(m.mesh.pin_motion[n])];
    const bool soft = m.mesh.soft_pin(static_cast<Index>(n)) > 0 && time < own->release,
               attached = own && own->body >= 0;
    if ((m.mesh.pinned[n] || soft) && !attached)
      throw std::invalid_argument(fmt::format("node {} of cloth {} is held by a pin of the scene", k, cloth));
    const Eigen::Vector3d arm = to_eigen(arm_of_point(body, position[n], time));
    PinMotion motion;
    motion.body = number;
    motion.center = to_vec3(to_eigen(m.mesh.rest_position[n]) - arm);
    motion.reach = arm.norm();
    m.mesh.pinned[n] = 1;
    m.mesh.pin_motion[n] = static_cast<Index>(m.pin_motions.size());
    m.pin_motions.push_back(std::move(motion));
  }
  drop_unused_motions(m);
}

void detach_nodes(Model& m, Index cloth, const std::vector<Index>& nodes) {
  const ClothMaterial& range = cloth_to_hold(m, cloth, nodes);
  m.fastest_before = fastest_prescribed(m);
  for (const Index k : nodes) {
    const auto n = static_cast<std::size_t>(range.first_node + k);
    Index* motion = m.mesh.pin_motion.empty() ? nullptr : &m.mesh.pin_motion[n];
    if (!motion || *motion < 0 || m.pin_motions[static_cast<std::size_t>(*motion)].body < 0)
      throw std::invalid_argument(fmt::format("node {} of cloth {} is not attached to a body", k, cloth));
    *motion = -1;
    m.mesh.pinned[n] = 0;
  }
  drop_unused_motions(m);
}

std::vector<Index> attached_nodes(const Model& m, Index body) {
  std::vector<Index> nodes;
  for (std::size_t n = 0; n < m.mesh.pin_motion.size(); ++n)
    if (m.mesh.pin_motion[n] >= 0 && m.pin_motions[static_cast<std::size_t>(m.mesh.pin_motion[n])].body == body)
      nodes.push_back(static_cast<Index>(n));
  return nodes;
}

void change_jet(Model& m, Index number, const Vec3& velocity, const std::optional<Vec3>& center, double time) {
  if (const auto jets = std::ssize(m.scene.fluid.jets); number < 0 || number >= jets)
    throw std::invalid_argument(fmt::format("there is no jet {}; the scene has {}", number, jets));
  require_within("the velocity of a jet", velocity, speed_range, "m/s");
  require_within("the centre of a jet", center.value_or(Vec3{}), coordinate_range, "m");
  const double before = fastest_prescribed(m);
  Jet& jet = m.jets[static_cast<std::size_t>(number)];
  if (velocity == Vec3{0, 0, 0}) {
    jet.scene.end = std::min(jet.scene.end, std::max(time, jet.scene.start));
    return;
  }
  if (jet.mouth)
    throw std::invalid_argument(fmt::format(
        "jet {} moves as the scene says; allowed: a velocity of 0, which closes it, or a jet without motion", number));
  JetScene next = m.scene.fluid.jets[static_cast<std::size_t>(number)];
  next.velocity = velocity;
  next.center = center.value_or(jet.scene.center);
  jet = continued(m, jet, next, time, fmt::format("jet {}", number));
  m.fastest_before = before;
}

const Body& body_numbered(const Model& m, Index body) {
  if (body < 0 || body >= std::ssize(m.bodies))
    throw std::invalid_argument(fmt::format("there is no body {}; the scene has {}", body, m.bodies.size()));
  return m.bodies[static_cast<std::size_t>(body)];
}

namespace {

/// A commanded body that a program may move, with the motion that it has come to by `time` as the beginning of another.
Body& body_to_move(Model& m, Index number, double time) {
  if (!body_numbered(m, number).commanded)
    throw std::invalid_argument(
        fmt::format("body {} cannot be moved by a program; allowed: bodies with commanded: true", number));
  m.fastest_before = fastest_prescribed(m);
  Body& body = m.bodies[static_cast<std::size_t>(number)];
  CommandedMotion next;
  next.moved = way_at(body, time);
  next.orientation = orientation_at(body, time);
  next.start = next.end = time;
  body.command = next;
  return body;
}

}  // namespace

void change_body_velocity(Model& m, Index number, const Vec3& velocity, const Vec3& spin, double time) {
  require_within("the velocity of a body", velocity, speed_range, "m/s");
  require_within("the angular velocity of a body", spin, turn_range, "rad/s");
  CommandedMotion& c = body_to_move(m, number, time).command;
  c.velocity = velocity;
  c.spin = spin;
  c.end = std::numeric_limits<double>::infinity();
}

void change_body_pose(Model& m, Index number, const Vec3& position, const Quaternion& orientation, double duration,
                      double time) {
  require_within("the position of a body", position, coordinate_range, "m");
  const Eigen::Quaterniond wanted(orientation[0], orientation[1], orientation[2], orientation[3]);
  if (!(std::isfinite(wanted.norm()) && wanted.norm() > 0))
    throw std::invalid_argument("the orientation of a body: the quaternion (w, x, y, z) must have a length above 0");
  if (!(duration > 1e-9 && std::isfinite(duration) && time + duration > time))
    throw std::invalid_argument(fmt::format("the duration of a motion must be above 1e-9 s, not {}", duration));
  Body& body = body_to_move(m, number, time);
  CommandedMotion& c = body.command;
  const Eigen::Quaterniond now(c.orientation[0], c.orientation[1], c.orientation[2], c.orientation[3]);
  Eigen::Quaterniond turn = wanted.normalized() * now.conjugate();
  if (turn.w() < 0) turn.coeffs() *= -1;  // the short way
  const Eigen::AngleAxisd about(turn);
  c.velocity = to_vec3((to_eigen(position) - to_eigen(body.center) - to_eigen(c.moved)) / duration);
  c.spin = to_vec3(about.angle() / duration * about.axis());
  c.end = time + duration;
}

void change_wrench(Model& m, Index number, const Vec3& force, const Vec3& torque) {
  if (!body_numbered(m, number).dynamic)
    throw std::invalid_argument(
        fmt::format("a wrench cannot act on body {}; allowed: bodies with dynamic: true", number));
  Body& body = m.bodies[static_cast<std::size_t>(number)];
  // What changes its velocity by the largest speed in one step, and that at its reach.
  const double most = body.mass * parse_range(speed_range).high / m.scene.time.step;
  const auto up_to = [](double limit) { return fmt::format("[{0:.3g}, {1:.3g}]", -limit, limit); };
  require_within("the force on a body", force, up_to(most), "N");
  require_within("the torque on a body", torque, up_to(most * body.reach), "N m");
  body.applied_force = force;
  body.applied_torque = torque;
}

void change_motor(Model& m, Index number, double speed) {
  if (number < 0 || number >= std::ssize(m.joints))
    throw std::invalid_argument(fmt::format("there is no joint {}; the scene has {}", number, m.joints.size()));
  Joint& joint = m.joints[static_cast<std::size_t>(number)];
  if (!(joint.torque > 0)) throw std::invalid_argument(fmt::format("joint {} has no motor", number));
  if (!std::isfinite(speed)) throw std::invalid_argument(fmt::format("the speed of a motor: {} is not finite", speed));
  if (!parse_range(turn_range).contains(speed))
    throw std::invalid_argument(fmt::format("the speed of a motor: {:g} rad/s; allowed: {}", speed, turn_range));
  joint.speed = speed;
}

void change_wind(Model& m, const Vec3& velocity) {
  require_within("the velocity of the wind", velocity, air_speed_range, "m/s");
  m.fastest_before = fastest_prescribed(m);
  m.scene.wind.present = true;
  m.scene.wind.velocity = velocity;
  m.scene.wind.gusts.clear();
}

std::vector<double> to_numbers(const Model& m) {
  const Prescribed p = prescribed_of(m);
  std::vector<double> numbers{static_cast<double>(p.pin_motions.size()), static_cast<double>(p.pin_motion.size()),
                              static_cast<double>(p.jets.size()), p.wind.present ? 1.0 : 0.0,
                              p.wind.gusts.empty() ? 0.0 : 1.0};
  for (std::size_t n = 0; n < p.pin_motion.size(); ++n) {
    numbers.push_back(p.pin_motion[n]);
    numbers.push_back(p.pinned[n]);
  }
  visit_numbers(p, [&](const double& value) { numbers.push_back(value); });
  return numbers;
}

void take_numbers(Model& m, const std::vector<double>& numbers) {
  const auto refuse = [] {
    throw std::invalid_argument("the changed bodies, pins, jets, motors and wind are of another scene");
  };
  if (numbers.size() < 5) refuse();
  Prescribed p = prescribed_of(m);
  const double nodes = numbers[1];
  if (numbers[2] != static_cast<double>(p.jets.size())) refuse();
  if (nodes != 0 && nodes != static_cast<double>(m.mesh.rest_position.size())) refuse();
  if (!(numbers[0] >= 0 && numbers[0] <= static_cast<double>(m.mesh.rest_position.size()))) refuse();
  p.pin_motions.resize(static_cast<std::size_t>(numbers[0]));
  p.pin_motion.resize(static_cast<std::size_t>(nodes));
  p.wind.present = numbers[3] != 0;
  if (numbers[4] == 0) p.wind.gusts.clear();
  std::size_t expected = 5 + 2 * p.pin_motion.size();
  visit_numbers(p, [&](double&) { ++expected; });
  if (numbers.size() != expected) refuse();
  auto next = numbers.begin() + 5;
  for (std::size_t n = 0; n < p.pin_motion.size(); ++n) {
    p.pin_motion[n] = static_cast<Index>(*next++);
    p.pinned[n] = *next++ != 0 ? 1 : 0;
    if (p.pin_motion[n] < -1 || p.pin_motion[n] >= std::ssize(p.pin_motions)) refuse();
  }
  visit_numbers(p, [&](double& value) { value = *next++; });
  for (const PinMotion& motion : p.pin_motions)
    if (motion.body < -1 || motion.body >= std::ssize(m.bodies)) refuse();
  for (std::size_t j = 0; j < m.scene.fluid.jets.size(); ++j)
    p.jets[j] = make_jet(m, p.jets[j].scene, "a jet of the checkpoint");
  prescribe(m, p);
}

}  // namespace drench
