#include "setup/emitters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/emitting_faces.hpp"
#include "setup/file_place.hpp"
#include "setup/fluid_sampling.hpp"
#include "setup/setup_error.hpp"
#include "setup/solute.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// The points of a square lattice (unit spacing) nearest to 0, in whole shells of equal distance, at least `area` of
/// them: layers of so many particles lie no closer than the spacing, so that a jet does not start compressed. In order
/// of their first coordinate (src/stages/jets.hpp).
std::vector<std::pair<int, int>> layer_points(double area) {
  const int reach = static_cast<int>(std::sqrt(area)) + 2;
  std::vector<std::pair<int, int>> points;
  for (int a = -reach; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b) points.emplace_back(a, b);
  const auto square = [](const std::pair<int, int>& p) { return p.first * p.first + p.second * p.second; };
  std::stable_sort(points.begin(), points.end(), [&](const auto& p, const auto& q) { return square(p) < square(q); });
  constexpr double rounding = 1e-9;
  std::size_t count = 0;
  while (count < points.size() &&
         (static_cast<double>(count) < area * (1 - rounding) || square(points[count]) == square(points[count - 1])))
    ++count;
  points.resize(count);
  std::sort(points.begin(), points.end());
  return points;
}

/// Two unit vectors normal to a unit vector and to each other.
std::array<Vec3, 2> across(const Vector3d& axis) {
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = axis.cross(Vector3d::Unit(smallest)).normalized();
  return {to_vec3(u), to_vec3(axis.cross(u))};
}

/// Points of a disc (m²) whose plane is along `sides`.
std::vector<Vec3> disc_points(double area, double d, const std::array<Vec3, 2>& sides) {
  std::vector<Vec3> points;
  for (const auto& [a, b] : layer_points(area / (d * d)))
    points.push_back(to_vec3(d * (a * to_eigen(sides[0]) + b * to_eigen(sides[1]))));
  return points;
}

/// Speeds and directions at the keys apart, so that a jet that turns does not slow down, and one that closes keeps its
/// axis.
void aim_by_keys(Jet& jet) {
  const Keyed<Vec3>& velocity = jet.scene.velocity;
  std::vector<Key<double>> speed;
  std::vector<Key<Vec3>> aim;
  for (const Key<Vec3>& key : velocity.keys()) {
    const double length = to_eigen(key.value).norm();
    speed.push_back({key.time, length});
    Vec3 unit{0, 0, 0};
    if (length > 0)
      unit = to_vec3(to_eigen(key.value) / length);
    else if (!aim.empty())
      unit = aim.back().value;
    aim.push_back({key.time, unit});
  }
  for (std::size_t k = aim.size() - 1; k-- > 0;)  // those before the first that has a direction
    if (aim[k].value == Vec3{0, 0, 0}) aim[k].value = aim[k + 1].value;
  jet.speed = Keyed<double>(std::move(speed), velocity.interpolation());
  jet.aim = Keyed<Vec3>(std::move(aim), velocity.interpolation());
}

/// Layers along a side of a rectangle, as of blocks.
int layers_along(double side, double d) {
  constexpr double widest = 1.05;  // of d
  const int layers = std::max(1, static_cast<int>(std::lround(side / d)));
  return side / layers > widest * d ? layers + 1 : layers;
}

/// A lattice that fills a rectangle with these sides, in an order in which neighbours are far apart.
std::vector<Vec3> rectangle_points(const std::array<double, 2>& size, const Vector3d& across, const Vector3d& up,
                                   double d) {
  const int a = layers_along(size[0], d), b = layers_along(size[1], d);
  const auto middle = [](int k, int layers) { return (k + 0.5) / layers - 0.5; };
  std::vector<std::pair<double, Vec3>> ordered;
  for (int i = 0; i < a; ++i)
    for (int k = 0; k < b; ++k)
      ordered.emplace_back(std::fmod(roberts[0] * i + roberts[1] * k, 1.0),
                           to_vec3(middle(i, a) * size[0] * across + middle(k, b) * size[1] * up));
  std::sort(ordered.begin(), ordered.end());
  std::vector<Vec3> points;
  for (const auto& [order, point] : ordered) points.push_back(point);
  return points;
}

/// The direction of the second side of a rectangle across `axis`.
Vector3d up_across(const JetScene& scene, const Vector3d& axis, const std::string& name) {
  constexpr double vertical = 0.999;  // of the cosine
  const Vector3d asked =
      scene.up ? to_eigen(*scene.up).normalized() : Vector3d::Unit(std::abs(axis.y()) > vertical ? 2 : 1);
  const Vector3d up = asked - asked.dot(axis) * axis;
  if (!(up.norm() > 1e-6))
    throw SetupError(name + ": the velocity is along `up`; allowed: an `up` that points across the velocity");
  return up.normalized();
}

PinMotion motion_of(const NozzleMotionScene& scene, const Vec3& center, double size) {
  PinMotion motion;
  motion.velocity = scene.velocity;
  motion.path = scene.offset;
  motion.axis = to_vec3(to_eigen(scene.spin.axis).normalized());
  motion.rate = scene.spin.degrees_per_second.scaled(std::numbers::pi / 180);
  motion.center = scene.center.value_or(center);
  motion.reach = (to_eigen(center) - to_eigen(motion.center)).norm() + size;
  return motion;
}

double reach_of(const std::vector<Vec3>& offsets) {
  double most = 0;
  for (const Vec3& offset : offsets) most = std::max(most, to_eigen(offset).norm());
  return most;
}

void check_inside(const Model& model, const Jet& jet, const std::string& name) {
  if (!contains(model.scene.domain.min, model.scene.domain.max, center_of_mouth(jet, jet.scene.start)))
    throw SetupError(name +
                     ": the centre is outside the domain when it starts to flow; move it, or enlarge the domain");
}

void check_count(double points, double most, double d, const std::string& name) {
  if (points > most)
    throw SetupError(
        fmt::format("{}: its mouth needs {:.3g} particles at spacing {} m; allowed: at most {:.0e}, so a "
                    "smaller mouth or a larger spacing",
                    name, points, d, most));
}

}  // namespace

std::string jet_label(const Model& model, std::size_t number) {
  const FluidScene& fluid = model.scene.fluid;
  const std::array<std::pair<const char*, std::size_t>, 4> kinds{{{"jet", fluid.jets.size()},
                                                                  {"rain", fluid.rains.size()},
                                                                  {"spray", fluid.sprays.size()},
                                                                  {"mesh_jet", fluid.mesh_jets.size()}}};
  std::size_t kind = 0;
  while (kind + 1 < kinds.size() && number >= kinds[kind].second) number -= kinds[kind++].second;
  return fmt::format("fluid: {} {}", kinds[kind].first, number);
}

Jet make_jet(const Model& model, const JetScene& scene, const std::string& name) {
  const double d = model.spacing;
  const bool disc = scene.shape == JetScene::Shape::disc;
  Jet jet;
  jet.scene = scene;
  jet.solute = solute_quanta(model, scene.concentration, quanta_per_particle);
  if (scene.velocity.has_keys()) aim_by_keys(jet);
  const Vector3d velocity = to_eigen(scene.velocity.has_keys() ? jet.aim.plain() : scene.velocity.plain());
  const double radius = scene.radius, speed = velocity.norm();
  if (disc && !(radius >= 0.5 * d)) {
    throw SetupError(fmt::format("{}: the radius {} m is below half the spacing, {} m", name, radius, 0.5 * d));
  }
  if (const double side = std::min(scene.size[0], scene.size[1]); !disc && side < d * (1 - 1e-9))
    throw SetupError(fmt::format("{}: the side {} m is below the spacing, {} m", name, side, d));
  if (!(speed > 0)) throw SetupError(name + ": the velocity must not be zero");
  if (!moves(scene.motion) && !contains(model.scene.domain.min, model.scene.domain.max, scene.center)) {
    throw SetupError(name + ": the centre is outside the domain; move it, or enlarge the domain");
  }
  jet.area = disc ? std::numbers::pi * radius * radius : scene.size[0] * scene.size[1];
  check_count(jet.area / (d * d), max_mouth_points, d, name);
  const Vector3d axis = velocity / speed;
  if (disc) {
    jet.offsets = disc_points(jet.area, d, across(axis));
  } else {
    const Vector3d up = up_across(scene, axis, name);
    jet.offsets = rectangle_points(scene.size, up.cross(axis), up, d);
  }
  if (!jet.has_keys()) jet.interval = d * d * d / (jet.area * speed);
  jet.advance = d * d * d / jet.area;
  if (!moves(scene.motion)) return jet;
  if (!jet.has_keys()) {
    jet.speed = speed;
    jet.aim = to_vec3(axis);
  }
  jet.mouth.emplace();
  jet.mouth->motion = motion_of(scene.motion, scene.center, reach_of(jet.offsets));
  jet.mouth->moves = true;
  jet.mouth->area = jet.area;
  jet.mouth->volumes = volumes_at_keys(jet);
  check_inside(model, jet, name);
  return jet;
}

Jet make_mesh_jet(const Model& model, const MeshJetScene& scene, const std::string& name) {
  const double d = model.spacing;
  const EmittingFaces faces = emitting_faces(scene, model.scene.path, d, name);
  Jet jet;
  jet.scene.start = scene.start;
  jet.scene.end = scene.end;
  jet.scene.concentration = scene.concentration;
  jet.scene.motion = scene.motion;
  jet.solute = solute_quanta(model, scene.concentration, quanta_per_particle);
  jet.scene.center = faces.center;
  for (const Vec3& x : faces.points.front()) jet.offsets.push_back(to_vec3(to_eigen(x) - to_eigen(faces.center)));
  jet.speed = scene.speed;
  jet.aim = scene.direction ? to_vec3(to_eigen(*scene.direction).normalized()) : Vec3{0, 1, 0};
  Mouth& mouth = jet.mouth.emplace();
  mouth.motion = motion_of(scene.motion, jet.scene.center, reach_of(jet.offsets));
  mouth.directions = faces.directions;
  mouth.flow = faces.flow;
  mouth.stride = golden_stride(static_cast<std::int64_t>(jet.offsets.size()));
  mouth.moves = moves(scene.motion) || faces.points.size() > 1;
  std::vector<Key<double>> areas = faces.area;
  for (const Key<double>& key : areas) jet.area = std::max(jet.area, key.value);
  mouth.area = areas.front().value;
  if (areas.size() > 1) {
    mouth.area = Keyed<double>(std::move(areas), Interpolation::linear);
    mouth.time = faces.time;
    mouth.points = faces.points;
    mouth.fastest_file = faces.fastest;
  }
  mouth.volumes = volumes_at_keys(jet);
  check_inside(model, jet, name);
  return jet;
}

Jet make_spray(const Model& model, const SprayScene& scene, const std::string& name) {
  constexpr double litres_per_minute = 1e-3 / 60;  // m³/s
  const double d = model.spacing;
  const Vector3d axis = to_eigen(scene.direction).normalized();
  const std::array<Vec3, 2> sides = across(axis);
  Jet jet;
  jet.scene.center = scene.center;
  jet.scene.start = scene.start;
  jet.scene.end = scene.end;
  jet.scene.concentration = scene.concentration;
  jet.scene.motion = scene.motion;
  jet.solute = solute_quanta(model, scene.concentration, quanta_per_particle);
  jet.area = scene.flow * litres_per_minute / scene.speed;
  check_count(jet.area / (d * d), max_mouth_points, d, name);
  jet.offsets = disc_points(jet.area, d, sides);
  jet.speed = scene.speed;
  jet.aim = to_vec3(axis);
  Mouth& mouth = jet.mouth.emplace();
  mouth.motion = motion_of(scene.motion, scene.center, reach_of(jet.offsets));
  mouth.stride = golden_stride(static_cast<std::int64_t>(jet.offsets.size()));
  mouth.moves = moves(scene.motion);
  mouth.area = jet.area;
  mouth.cone = {std::cos(scene.half_angle * std::numbers::pi / 180), sides};
  mouth.volumes = volumes_at_keys(jet);
  check_inside(model, jet, name);
  return jet;
}

Jet make_rain(const Model& model, const RainScene& scene, const std::string& name) {
  const double d = model.spacing, area = scene.size[0] * scene.size[1];
  const Vector3d gravity = to_eigen(model.scene.gravity);
  Jet jet;
  jet.scene.center = scene.center;
  jet.scene.start = scene.start;
  jet.scene.end = scene.end;
  Vector3d velocity;
  if (scene.velocity) {
    velocity = to_eigen(*scene.velocity);
  } else {
    if (!(gravity.norm() > 0)) throw SetupError(name + ": without gravity the drops need a velocity");
    // Atlas, Srivastava and Sekhon 1973, for drops of 0.6 to 5.8 mm; below, in proportion to the diameter.
    const double mm = 1e3 * scene.diameter;
    const auto fitted = [](double x) { return 9.65 - 10.3 * std::exp(-0.6 * x); };
    const double speed = mm < 0.6 ? fitted(0.6) * mm / 0.6 : fitted(mm);
    velocity = speed * gravity.normalized();
  }
  jet.scene.velocity = to_vec3(velocity);
  if (!contains(model.scene.domain.min, model.scene.domain.max, scene.center))
    throw SetupError(name + ": the centre is outside the domain; move it, or enlarge the domain");
  const double full = d * d * d, drop = std::numbers::pi / 6 * std::pow(scene.diameter, 3);
  if (drop > full * (1 + 1e-9))
    throw SetupError(
        fmt::format("{}: drops of {} m are larger than a particle; allowed: up to {:.3g} m at a spacing of "
                    "{} m",
                    name, scene.diameter, std::cbrt(6 / std::numbers::pi) * d, d));
  constexpr double lightest = 0.125;                       // of a full particle's mass
  const double drops = std::ceil(lightest * full / drop);  // in a particle
  jet.mass = std::llround(drops * drop / full * static_cast<double>(quanta_per_particle));
  jet.solute = solute_quanta(model, scene.concentration, jet.mass);
  constexpr double per_mm_per_hour = 1e-3 / 3600;  // m/s
  jet.interval = drops * drop / (scene.rate * per_mm_per_hour * area);
  jet.area = scene.rate * per_mm_per_hour * area / velocity.norm();
  Eigen::Index down = 1;
  if (gravity.norm() > 0) gravity.cwiseAbs().maxCoeff(&down);
  const std::array<std::size_t, 2> level{down == 0 ? 1U : 0U, down == 2 ? 1U : 2U};
  constexpr int points = 4096;
  for (int k = 0; k < points; ++k) {
    const double a = std::fmod(0.5 + roberts[0] * k, 1.0) - 0.5, b = std::fmod(0.5 + roberts[1] * k, 1.0) - 0.5;
    Vec3 offset{0, 0, 0};
    offset[level[0]] = a * scene.size[0];
    offset[level[1]] = b * scene.size[1];
    jet.offsets.push_back(offset);
  }
  return jet;
}

std::vector<Jet> make_jets(const Model& model, std::vector<std::string>& warnings) {
  std::vector<Jet> jets;
  const FluidScene& fluid = model.scene.fluid;
  const std::size_t rains = fluid.jets.size(), sprays = rains + fluid.rains.size(),
                    meshes = sprays + fluid.sprays.size();
  for (std::size_t j = 0; j < meshes + fluid.mesh_jets.size(); ++j) {
    const std::string name = jet_label(model, j);
    Jet jet = j < rains    ? make_jet(model, fluid.jets[j], name)
              : j < sprays ? make_rain(model, fluid.rains[j - rains], name)
              : j < meshes ? make_spray(model, fluid.sprays[j - sprays], name)
                           : make_mesh_jet(model, fluid.mesh_jets[j - meshes], name);
    if (j >= meshes) {
      const PlacedFile& placed = fluid.mesh_jets[j - meshes].placed;
      if (std::string hint = unit_hint(mouth_at(jet, 0), placed.unit, placed.scale, name); !hint.empty())
        warnings.push_back(std::move(hint));
    }
    const std::vector<Vec3> mouth = mouth_at(jet, jet.scene.start);
    const auto solid = inside_solid(model, mouth);
    if (const auto free = std::count(solid.begin(), solid.end(), 0); free < std::ssize(solid)) {
      std::set<std::size_t> bodies;
      for (const std::size_t number : solid)
        if (number > 0) bodies.insert(number - 1);
      warnings.push_back(
          fmt::format("{}: {} of the {} points of its mouth are inside a solid body ({}); move one of them", name,
                      std::ssize(solid) - free, mouth.size(), body_labels(model.bodies, bodies)));
    }
    jets.push_back(std::move(jet));
  }
  return jets;
}

}  // namespace drench
