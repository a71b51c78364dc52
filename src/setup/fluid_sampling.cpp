#include "setup/fluid_sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "base/eigen_vec.hpp"
#include "setup/block_lattice.hpp"
#include "setup/body_geometry.hpp"
#include "setup/mesh_io.hpp"
#include "setup/point_grid.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

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

}  // namespace

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

double expected_block_particles(const FluidScene& fluid, const std::vector<SourceFile>& files) {
  double count = 0;
  for (std::size_t b = 0; b < fluid.blocks.size(); ++b)
    count += expected_particles(fluid.blocks[b], files[b], fluid.spacing);
  return count;
}

namespace {

/// "block 2", "blocks 1, 2, 5 and 7 more"
std::string block_names(const std::set<std::size_t>& numbers) {
  constexpr std::size_t most = 4;
  std::string text = numbers.size() > 1 ? "blocks" : "block";
  std::size_t k = 0;
  for (const std::size_t number : numbers) {
    if (k == most) return text + fmt::format(" and {} more", numbers.size() - most);
    text += fmt::format("{} {}", k > 0 ? "," : "", number);
    ++k;
  }
  return text;
}

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
          b, d, static_cast<double>(lattice.least_mass()) / full, static_cast<double>(model.min_quanta) / full));
    if (lattice.squeezed_axes().empty()) continue;
    if (!first) first = lattice;
    narrowed.insert(b);
  }
  if (!first) return;
  const Vec3& step = first->step();
  warnings.push_back(fmt::format(
      "fluid: the size of {} is not a multiple of the spacing, {:.4g} m. To hold the mass that block {} encloses, its "
      "particles are closer along {} ({:.4g}, {:.4g} and {:.4g} m) and have {:.3g} of a full particle's mass; use "
      "multiples of the spacing, or a smaller spacing",
      block_names(narrowed), d, *narrowed.begin(), first->squeezed_axes(), step[0], step[1], step[2],
      static_cast<double>(first->least_mass()) / full));
}

/// The particles of all blocks without what overlaps an earlier block. Throws SetupError if one lies outside the
/// domain.
BlockParticles lay_blocks(Model& model, std::vector<SourceFile> files, std::vector<std::string>& warnings) {
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
        overlapping.insert(b);
        return;
      }
      if (b > 0 && placed.any_within(x, 0.9 * closest)) {
        ++close;
        squeezed.insert(b);
      }
      if (!contains(model.scene.domain.min, model.scene.domain.max, x)) ++outside;
      add(laid, x, velocity, mass, b);
    };
    if (blocks[b].shape == BlockScene::Shape::box) {
      const BlockLattice lattice(blocks[b].box, d);
      closest = std::min(closest, lattice.narrowest());
      lattice.for_each([&](const Vec3& x, Quanta mass) { lay(x, blocks[b].velocity, mass); });
    } else {
      const std::string label = block_label(blocks[b], b);
      const auto particles = start_particles(model, blocks[b], std::move(files[b]), label);
      if (blocks[b].shape == BlockScene::Shape::particles) warn_of_distances(model, particles, label, true, warnings);
      for (const StartParticle& p : particles) lay(p.position, p.velocity, p.mass);
    }
    if (b + 1 == blocks.size()) break;
    for (std::size_t i = begin; i < positions.size(); ++i) placed.add(positions[i]);
  }
  if (outside > 0)
    throw SetupError(fmt::format(
        "fluid: {} of the blocks' {} particles are outside the domain: enlarge the domain, or move the block", outside,
        positions.size()));
  if (overlaps > 0)
    warnings.push_back(
        fmt::format("fluid: {} particles are omitted where blocks overlap ({} with an earlier one): move or "
                    "shrink one of them",
                    overlaps, block_names(overlapping)));
  if (close > 0)
    warnings.push_back(
        fmt::format("fluid: {} particles start closer than 0.9 spacings to an earlier block's ({}): the liquid is "
                    "compressed there and bursts; leave one spacing between the blocks, or a multiple of it",
                    close, block_names(squeezed)));
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
    cutting.insert(solid[i] - 1);
  }
  if (const std::size_t removed = all.block.size() - kept.block.size())
    warnings.push_back(
        fmt::format("fluid: {} of the blocks' {} particles removed: they start inside a solid body ({} in {}); "
                    "move or shrink one of them",
                    removed, all.block.size(), block_names(cut), body_labels(model.bodies, cutting)));
  return kept;
}

/// Of shapes that have exact distances. A source that ends at a wall leaves half a spacing.
void warn_of_particles_at_walls(const Model& model, const BlockParticles& laid, std::vector<std::string>& warnings) {
  constexpr double nearest = 0.4, many = 0.02;  // spacings; of all particles
  std::set<std::size_t> pressed, walls;
  std::size_t count = 0;
  Vec3 normal;
  for (std::size_t i = 0; i < laid.position.size(); ++i)
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      const Body& body = model.bodies[b];
      if (body.kind == BodyScene::Kind::mesh) continue;
      if (!(signed_distance(body, laid.position[i], normal) < nearest * model.spacing)) continue;
      pressed.insert(laid.block[i]);
      walls.insert(b);
      ++count;
      break;
    }
  if (static_cast<double>(count) > many * static_cast<double>(laid.position.size()))
    warnings.push_back(
        fmt::format("fluid: {} of the blocks' particles start closer than {} spacings to a wall ({} at {}): the liquid "
                    "is compressed there and bursts; end the block at the wall, or half a spacing from it",
                    count, nearest, block_names(pressed), body_labels(model.bodies, walls)));
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
                    count, 0.5 * d, block_names(touching), d));
}

}  // namespace

BlockParticles fill_blocks(Model& model, std::vector<SourceFile> files, std::vector<std::string>& warnings) {
  check_lattices(model, warnings);
  const BlockParticles all = lay_blocks(model, std::move(files), warnings);
  BlockParticles laid = outside_solids(model, all, warnings);
  if (laid.position.size() == all.position.size()) warn_of_particles_at_walls(model, laid, warnings);
  warn_of_particles_at_cloth(model, laid, warnings);
  return laid;
}

}  // namespace drench
