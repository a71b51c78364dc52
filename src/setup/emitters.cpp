#include "setup/emitters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/fluid_sampling.hpp"
#include "setup/setup_error.hpp"
#include "setup/solute.hpp"

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

}  // namespace

std::string jet_label(const Model& model, std::size_t number) {
  const std::size_t jets = model.scene.fluid.jets.size();
  return number < jets ? fmt::format("fluid: jet {}", number + 1) : fmt::format("fluid: rain {}", number - jets + 1);
}

Jet make_jet(const Model& model, const JetScene& scene, const std::string& name) {
  const double d = model.spacing;
  Jet jet;
  jet.scene = scene;
  jet.solute = solute_quanta(model, scene.concentration, quanta_per_particle);
  if (scene.velocity.has_keys()) aim_by_keys(jet);
  const Vector3d velocity = to_eigen(scene.velocity.has_keys() ? jet.aim.plain() : scene.velocity.plain());
  const double radius = scene.radius, speed = velocity.norm();
  if (!(radius >= 0.5 * d)) {
    throw SetupError(fmt::format("{}: the radius {} m is below half the spacing, {} m", name, radius, 0.5 * d));
  }
  if (!(speed > 0)) throw SetupError(name + ": the velocity must not be zero");
  if (!contains(model.scene.domain.min, model.scene.domain.max, scene.center)) {
    throw SetupError(name + ": the centre is outside the domain");
  }
  const Vector3d axis = velocity / speed;
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = axis.cross(Vector3d::Unit(smallest)).normalized(), v = axis.cross(u);
  if (const double points = std::numbers::pi * radius * radius / (d * d); points > max_mouth_points)
    throw SetupError(
        fmt::format("{}: its mouth needs {:.3g} particles at spacing {} m; allowed: at most {:.0e}, so a "
                    "smaller radius or a larger spacing",
                    name, points, d, max_mouth_points));
  for (const auto& [a, b] : layer_points(std::numbers::pi * radius * radius / (d * d)))
    jet.offsets.push_back(to_vec3(d * (a * u + b * v)));
  if (!jet.has_keys()) jet.interval = d * d * d / (std::numbers::pi * radius * radius * speed);
  jet.advance = d * d * d / (std::numbers::pi * radius * radius);
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
    throw SetupError(name + ": the centre is outside the domain");
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
  jet.scene.radius = std::sqrt(scene.rate * per_mm_per_hour * area / (std::numbers::pi * velocity.norm()));
  Eigen::Index down = 1;
  if (gravity.norm() > 0) gravity.cwiseAbs().maxCoeff(&down);
  const std::array<std::size_t, 2> level{down == 0 ? 1U : 0U, down == 2 ? 1U : 2U};
  // Roberts' sequence: 1/g and 1/g² of the root g of g³ = g + 1. Points that follow each other are far apart.
  constexpr double first = 0.7548776662466927, second = 0.5698402909980532;
  constexpr int points = 4096;
  for (int k = 0; k < points; ++k) {
    const double a = std::fmod(0.5 + first * k, 1.0) - 0.5, b = std::fmod(0.5 + second * k, 1.0) - 0.5;
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
  for (std::size_t j = 0; j < fluid.jets.size() + fluid.rains.size(); ++j) {
    const bool rain = j >= fluid.jets.size();
    const std::string name = jet_label(model, j);
    Jet jet = rain ? make_rain(model, fluid.rains[j - fluid.jets.size()], name) : make_jet(model, fluid.jets[j], name);
    std::vector<Vec3> mouth;
    for (const Vec3& offset : jet.offsets) mouth.push_back(to_vec3(to_eigen(jet.scene.center) + to_eigen(offset)));
    const auto solid = inside_solid(model, mouth);
    if (const auto free = std::count(solid.begin(), solid.end(), 0); free < std::ssize(solid)) {
      std::set<std::size_t> bodies(solid.begin(), solid.end());
      bodies.erase(0);
      warnings.push_back(
          fmt::format("{}: {} of the {} points of its mouth are inside a solid body ({}); move one of them", name,
                      std::ssize(solid) - free, mouth.size(), named("body", "bodies", bodies)));
    }
    jets.push_back(std::move(jet));
  }
  return jets;
}

}  // namespace drench
