#include "setup/fluid_sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

#include "base/eigen_vec.hpp"
#include "setup/block_lattice.hpp"
#include "setup/body_geometry.hpp"
#include "setup/liquid_shapes.hpp"
#include "setup/mesh_io.hpp"
#include "setup/point_grid.hpp"
#include "setup/setup_error.hpp"
#include "setup/solute.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// For each point the number, from 1, of the first solid that it is inside of, or 0; thin walls have no inside.
std::vector<std::size_t> inside_solid(const Model& model, const std::vector<Vec3>& points) {
  std::vector<std::size_t> inside(points.size(), 0);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.kind == BodyScene::Kind::mesh) {
      if (body.field.empty()) continue;
      const auto in_mesh = points_inside({body.mesh_points, body.mesh_triangles}, points);
      for (std::size_t i = 0; i < points.size(); ++i)
        if (inside[i] == 0 && in_mesh[i]) inside[i] = b + 1;
      continue;
    }
    Vec3 normal;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (inside[i] == 0 && signed_distance(body, points[i], normal) < 0) inside[i] = b + 1;
  }
  return inside;
}

/// Squared distance of p to a triangle: the nearest point of its plane if that lies inside, else of its sides.
double distance_squared(const Vector3d& p, const std::array<Vector3d, 3>& t) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    const Vector3d side = t[(c + 1) % 3] - t[c], from = p - t[c];
    if (normal.dot(side.cross(from)) < 0) inside = false;
    const double s = std::clamp(from.dot(side) / side.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (from - s * side).squaredNorm());
  }
  if (!inside) return nearest;
  const double height = normal.dot(p - t[0]);
  return height * height / normal.squaredNorm();
}

/// "block 2", "blocks 1, 2, 5 and 7 more"
std::string named(const std::string& one, const std::string& many, const std::set<std::size_t>& numbers) {
  constexpr std::size_t most = 4;
  std::string text = numbers.size() > 1 ? many : one;
  std::size_t k = 0;
  for (const std::size_t number : numbers) {
    if (k == most) return text + fmt::format(" and {} more", numbers.size() - most);
    text += fmt::format("{} {}", k > 0 ? "," : "", number);
    ++k;
  }
  return text;
}

}  // namespace

std::vector<std::uint8_t> near_cloth(const Model& model, const std::vector<Vec3>& points, double distance) {
  std::vector<std::uint8_t> near(points.size(), 0);
  if (points.empty() || !model.has_cloth()) return near;
  PointGrid grid(2 * model.spacing);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : points) {
    grid.add(x);
    bounds.extend(to_eigen(x));
  }
  for (const auto& n : model.mesh.triangle) {
    std::array<Vector3d, 3> t;
    Eigen::AlignedBox3d box;
    for (int c = 0; c < 3; ++c) {
      t[c] = to_eigen(model.mesh.rest_position[static_cast<std::size_t>(n[c])]);
      box.extend(t[c]);
    }
    box.min().array() -= distance;
    box.max().array() += distance;
    box.clamp(bounds);
    if (box.isEmpty()) continue;
    grid.for_box(to_vec3(box.min()), to_vec3(box.max()), [&](Index p) {
      const auto i = static_cast<std::size_t>(p);
      if (!near[i] && distance_squared(to_eigen(points[i]), t) < distance * distance) near[i] = 1;
    });
  }
  return near;
}

namespace {

std::string label_of(std::size_t block) { return fmt::format("fluid: block {}", block + 1); }

}  // namespace

double expected_block_particles(const Scene& scene) {
  double count = 0;
  for (std::size_t b = 0; b < scene.fluid.blocks.size(); ++b)
    count += expected_particles(scene, scene.fluid.blocks[b], label_of(b));
  return count;
}

namespace {

void add(BlockParticles& particles, const Vec3& position, const Vec3& velocity, Quanta mass, std::size_t block) {
  particles.position.push_back(position);
  particles.velocity.push_back(velocity);
  particles.mass.push_back(mass);
  particles.block.push_back(block);
}

/// Rejects blocks of too light particles, and warns where layers are much narrower than the spacing.
void check_lattices(const Model& model, std::vector<std::string>& warnings) {
  const double d = model.spacing, full = static_cast<double>(quanta_per_particle);
  const auto& blocks = model.scene.fluid.blocks;
  std::set<std::size_t> narrowed;
  std::optional<BlockLattice> first;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].shape != BlockScene::Shape::box) continue;
    const BlockLattice lattice(blocks[b].box, d);
    if (lattice.least_mass() < model.min_quanta)
      throw SetupError(fmt::format(
          "fluid: block {} is much thinner than the spacing, {} m: each particle would have {:.2g} of a full "
          "particle's "
          "mass; allowed: at least {:.2g}; use a smaller spacing or a larger block",
          b + 1, d, static_cast<double>(lattice.least_mass()) / full, static_cast<double>(model.min_quanta) / full));
    if (lattice.squeezed_axes().empty()) continue;
    if (!first) first = lattice;
    narrowed.insert(b + 1);
  }
  if (!first) return;
  const Vec3& step = first->step();
  warnings.push_back(fmt::format(
      "fluid: the size of {} is not a multiple of the spacing, {:.4g} m. To hold the mass that block {} encloses, its "
      "particles are closer along {} ({:.4g}, {:.4g} and {:.4g} m) and have {:.3g} of a full particle's mass; use "
      "multiples of the spacing, or a smaller spacing",
      named("block", "blocks", narrowed), d, *narrowed.begin(), first->squeezed_axes(), step[0], step[1], step[2],
      static_cast<double>(first->least_mass()) / full));
}

/// The particles of all blocks without what overlaps an earlier block. Throws SetupError if one lies outside the
/// domain.
BlockParticles lay_blocks(Model& model, std::vector<std::string>& warnings) {
  const double d = model.spacing;
  auto& blocks = model.scene.fluid.blocks;
  BlockParticles laid;
  const std::vector<Vec3>& positions = laid.position;
  PointGrid placed(d);
  std::size_t overlaps = 0, outside = 0, close = 0;
  std::set<std::size_t> overlapping, squeezed;
  double closest = d;  // m: between layers of a block so far
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::size_t begin = positions.size();
    const auto lay = [&](const Vec3& x, const Vec3& velocity, Quanta mass) {
      if (b > 0 && placed.any_within(x, 0.5 * d)) {
        ++overlaps;
        overlapping.insert(b + 1);
        return;
      }
      if (b > 0 && placed.any_within(x, 0.9 * closest)) {
        ++close;
        squeezed.insert(b + 1);
      }
      if (!contains(model.scene.domain.min, model.scene.domain.max, x)) ++outside;
      add(laid, x, velocity, mass, b + 1);
    };
    if (blocks[b].shape == BlockScene::Shape::box) {
      const BlockLattice lattice(blocks[b].box, d);
      closest = std::min(closest, lattice.narrowest());
      lattice.for_each([&](const Vec3& x, Quanta mass) { lay(x, blocks[b].velocity, mass); });
    } else {
      for (const StartParticle& p : start_particles(model, blocks[b], label_of(b), warnings))
        lay(p.position, p.velocity, p.mass);
    }
    if (b + 1 == blocks.size()) break;
    for (std::size_t i = begin; i < positions.size(); ++i) placed.add(positions[i]);
  }
  if (outside > 0)
    throw SetupError(
        fmt::format("fluid: {} of the blocks' {} particles are outside the domain", outside, positions.size()));
  if (overlaps > 0)
    warnings.push_back(
        fmt::format("fluid: {} particles are omitted where blocks overlap ({} with an earlier one): move or "
                    "shrink one of them",
                    overlaps, named("block", "blocks", overlapping)));
  if (close > 0)
    warnings.push_back(
        fmt::format("fluid: {} particles start closer than 0.9 spacings to an earlier block's ({}): the liquid is "
                    "compressed there and bursts; leave one spacing between the blocks, or a multiple of it",
                    close, named("block", "blocks", squeezed)));
  return laid;
}

/// Those of them that are in no solid.
BlockParticles outside_solids(const Model& model, const BlockParticles& all, std::vector<std::string>& warnings) {
  const auto solid = inside_solid(model, all.position);
  BlockParticles kept;
  std::set<std::size_t> cut, cutting;
  for (std::size_t i = 0; i < solid.size(); ++i) {
    if (solid[i] == 0) {
      add(kept, all.position[i], all.velocity[i], all.mass[i], all.block[i]);
      continue;
    }
    cut.insert(all.block[i]);
    cutting.insert(solid[i]);
  }
  if (const std::size_t removed = all.block.size() - kept.block.size())
    warnings.push_back(
        fmt::format("fluid: {} of the blocks' {} particles removed: they start inside a solid body ({} in {}); "
                    "move or shrink one of them",
                    removed, all.block.size(), named("block", "blocks", cut), named("body", "bodies", cutting)));
  return kept;
}

void warn_of_particles_at_cloth(const Model& model, const BlockParticles& laid, std::vector<std::string>& warnings) {
  const double d = model.spacing;
  const auto near = near_cloth(model, laid.position, nearest_to_cloth * d);
  std::set<std::size_t> touching;
  for (std::size_t i = 0; i < near.size(); ++i)
    if (near[i]) touching.insert(laid.block[i]);
  if (const auto count = std::count(near.begin(), near.end(), 1))
    warnings.push_back(
        fmt::format("fluid: {} of the blocks' particles start within {:.3g} m of a cloth, half a spacing ({}), and are "
                    "pushed out at once; keep {:.3g} m between the block and the cloth",
                    count, 0.5 * d, named("block", "blocks", touching), d));
}

}  // namespace

BlockParticles fill_blocks(Model& model, std::vector<std::string>& warnings) {
  check_lattices(model, warnings);
  BlockParticles laid = outside_solids(model, lay_blocks(model, warnings), warnings);
  warn_of_particles_at_cloth(model, laid, warnings);
  return laid;
}

namespace {

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
