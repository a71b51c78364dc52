#include "setup/liquid_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/eigen_vec.hpp"
#include "base/free_cores.hpp"
#include "setup/block_lattice.hpp"
#include "setup/body_geometry.hpp"
#include "setup/distance_field.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_files.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/mesh_moments.hpp"
#include "setup/point_grid.hpp"
#include "setup/relax_points.hpp"
#include "setup/setup_error.hpp"
#include "setup/solid_mesh.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Shape = BlockScene::Shape;

/// A volume to fill.
struct Volume {
  Box bounds;       // m
  double size = 0;  // m³
  Depth depth;
};

Body closed_mesh(const std::string& scene_path, const PlacedFile& placed, const std::string& name,
                 std::vector<std::string>& warnings, std::vector<std::string>& hints) {
  BodyScene body;
  body.kind = BodyScene::Kind::mesh;
  body.file = placed.file;
  body.scale = placed.scale;
  body.unit = placed.unit;
  body.up = placed.up;
  body.position = placed.position;
  body.rotate_axis = placed.rotate_axis;
  body.rotate_degrees = placed.rotate_degrees;
  Body made = make_body(body, scene_path, name, &warnings, MeshUse::liquid);
  if (!bounds_solid(made.mesh_triangles))
    throw SetupError(fmt::format("{}: the mesh {} encloses no volume to fill; allowed: a mesh that encloses a volume",
                                 name, placed.file));
  if (std::string hint = unit_hint(made.mesh_points, placed.unit, placed.scale, name); !hint.empty())
    hints.push_back(std::move(hint));
  return made;
}

double volume_of(const Body& mesh) {
  return moments_of(mesh.mesh_points, mesh.mesh_triangles, mesh.mesh_points.front()).volume;
}

double volume_of(const BlockScene& block, const SourceFile& file) {
  return block.shape == Shape::sphere ? 4.0 / 3 * std::numbers::pi * std::pow(block.radius, 3) : volume_of(file.mesh);
}

Volume volume_to_fill(const BlockScene& block, SourceFile file, double spacing) {
  Volume volume{{}, volume_of(block, file), {}};
  if (block.shape == Shape::sphere) {
    const Vec3 c = block.center;
    const double r = block.radius;
    volume.bounds = {{c[0] - r, c[1] - r, c[2] - r}, {c[0] + r, c[1] + r, c[2] + r}};
    volume.depth = [c, r](const Vec3& x, Vec3& inward) {
      const Vector3d away = to_eigen(x) - to_eigen(c);
      const double length = away.norm();
      inward = length > 0 ? to_vec3(-away / length) : Vec3{0, 1, 0};
      return r - length;
    };
    return volume;
  }
  Body& mesh = file.mesh;
  volume.bounds = bounds_of(mesh.mesh_points);
  mesh.field = lay_field(mesh, spacing, 2 * spacing);
  fill_field(mesh, mesh.field, host_threads());
  volume.depth = [field = std::move(mesh.field)](const Vec3& x, Vec3& inward) {
    Vec3 outward;
    const double distance = field_distance(field, x, outward);
    for (std::size_t a = 0; a < 3; ++a) inward[a] = -outward[a];
    return -distance;
  };
  return volume;
}

/// The deepest of the lattice's points, nearest in number to `wanted` in whole groups of equal depth, in the order of
/// the lattice.
std::vector<Vec3> deepest(const BlockLattice& lattice, const Volume& volume, double wanted, double spacing) {
  std::vector<Vec3> points;
  std::vector<double> depth;
  lattice.for_each([&](const Vec3& x, Quanta) {
    Vec3 inward;
    const double d = volume.depth(x, inward);
    if (d < -spacing) return;
    points.push_back(x);
    depth.push_back(d);
  });
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depth[a] > depth[b]; });
  const double equal = 1e-6 * spacing;
  std::size_t best = 0;
  for (std::size_t k = 1; k <= order.size(); ++k) {
    if (k < order.size() && depth[order[k - 1]] - depth[order[k]] < equal) continue;
    const auto miss = [&](std::size_t count) { return std::abs(static_cast<double>(count) - wanted); };
    if (miss(k) < miss(best)) best = k;
    if (static_cast<double>(k) > wanted) break;
  }
  order.resize(best);
  std::sort(order.begin(), order.end());
  std::vector<Vec3> chosen;
  for (const std::size_t i : order) chosen.push_back(points[i]);
  return chosen;
}

/// Is one of them nearer to a boundary particle than 1.2 spacings?
bool touches_solid(const Model& model, const std::vector<Vec3>& points) {
  const double near = 1.2 * model.spacing;
  PointGrid grid(near);
  for (const Vec3& x : model.boundary.position) grid.add(x);
  return std::any_of(points.begin(), points.end(), [&](const Vec3& x) { return grid.any_within(x, near); });
}

std::vector<StartParticle> fill(const Model& model, BlockScene& block, SourceFile file, const std::string& name) {
  const double d = model.spacing;
  const Volume volume = volume_to_fill(block, std::move(file), d);
  block.box = volume.bounds;
  const BlockLattice lattice(volume.bounds, d);
  const Vec3& step = lattice.step();
  const double cell = step[0] * step[1] * step[2];
  std::vector<Vec3> points = deepest(lattice, volume, volume.size / cell, d);
  const double full = static_cast<double>(quanta_per_particle);
  const Quanta all = std::llround(volume.size / (d * d * d) * full);
  const auto count = static_cast<Quanta>(points.size());
  if (count == 0 || volume.size < d * d * d)
    throw SetupError(fmt::format(
        "{}: its volume of {:.3g} m³ is less than a particle's, {:.3g} m³; use a smaller spacing or a larger "
        "volume",
        name, volume.size, d * d * d));
  if (all / count < model.min_quanta)
    throw SetupError(
        fmt::format("{} is much thinner than the spacing, {} m: each particle would have {:.2g} of a full particle's "
                    "mass; allowed: "
                    "at least {:.2g}; use a smaller spacing or a thicker shape",
                    name, d, static_cast<double>(all / count) / full, static_cast<double>(model.min_quanta) / full));
  const Vector3d middle = 0.5 * (to_eigen(volume.bounds.min) + to_eigen(volume.bounds.max));
  const double wider = std::cbrt(volume.size / (static_cast<double>(count) * cell));
  for (Vec3& x : points) x = to_vec3(middle + wider * (to_eigen(x) - middle));
  if (touches_solid(model, points))
    relax_points(points, volume.size / static_cast<double>(count), volume.depth, model.scene.fluid.kernel,
                 model.support);
  std::vector<StartParticle> particles;
  for (const Vec3& x : points) {
    const auto k = static_cast<Quanta>(particles.size());
    particles.push_back({x, block.velocity, all / count + (k < all % count ? 1 : 0)});
  }
  return particles;
}

std::vector<StartParticle> placed(const Model& model, BlockScene& block, ParticleFile file, const std::string& name) {
  const FilePlace place = file_place(block.placed);
  place(file.position);
  block.box = bounds_of(file.position);
  std::vector<StartParticle> particles(file.position.size());
  for (std::size_t i = 0; i < particles.size(); ++i) {
    StartParticle& p = particles[i];
    p.position = file.position[i];
    p.velocity = file.velocity.empty() ? block.velocity : to_vec3(place.linear * to_eigen(file.velocity[i]));
    p.mass = file.mass.empty() ? quanta_per_particle : std::llround(file.mass[i] / model.quantum);
    if (p.mass < 1 || p.mass > 2 * quanta_per_particle)
      throw SetupError(
          fmt::format("{}: particle {} of {} has a mass of {:.3g} kg; allowed: up to {:.3g} kg, two full "
                      "particles of this spacing",
                      name, i, block.placed.file, file.mass[i], 2 * model.particle_mass));
  }
  return particles;
}

}  // namespace

namespace {

bool has_no_faces(const std::string& path) {
  if (path.ends_with(".obj")) return read_obj_file(path).face_end.empty();
  if (path.ends_with(".ply")) return read_ply_file(path).face_end.empty();
  return false;
}

}  // namespace

const char* kind_of(const BlockScene& block) {
  switch (block.shape) {
    case Shape::box:
      return "block";
    case Shape::sphere:
      return "sphere source";
    case Shape::mesh:
      return "mesh source";
    case Shape::particles:
      return "particle source";
  }
  return "source";
}

std::string block_label(const BlockScene& block, std::size_t number) {
  return fmt::format("fluid: {} {}", kind_of(block), number);
}

SourceFile read_source_file(const std::string& scene_path, const BlockScene& block, std::size_t number,
                            std::vector<std::string>& warnings, std::vector<std::string>& hints) {
  SourceFile file;
  const bool of_sequence = !block.sequence.files.empty();
  if (block.shape == Shape::mesh && !(of_sequence && has_no_faces(block.placed.file)))
    file.mesh = closed_mesh(scene_path, block.placed, block_label(block, number), warnings, hints);
  if (block.shape == Shape::particles) file.particles = read_particle_file(block.placed.file, of_sequence);
  return file;
}

std::vector<SourceFile> read_source_files(const Scene& scene, std::vector<std::string>& warnings,
                                          std::vector<std::string>& hints) {
  std::vector<SourceFile> files;
  for (std::size_t b = 0; b < scene.fluid.blocks.size(); ++b)
    files.push_back(read_source_file(scene.path, scene.fluid.blocks[b], b, warnings, hints));
  return files;
}

double expected_particles(const BlockScene& block, const SourceFile& file, double spacing) {
  if (block.shape == Shape::mesh && file.mesh.mesh_triangles.empty()) return 0;
  if (block.shape == Shape::box) return BlockLattice(block.box, spacing).count();
  if (block.shape == Shape::particles) return static_cast<double>(file.particles.position.size());
  return std::ceil(1.05 * volume_of(block, file) / std::pow(spacing, 3));
}

void warn_of_distances(const Model& model, const std::vector<StartParticle>& particles, const std::string& name,
                       bool pushes, std::vector<std::string>& warnings) {
  constexpr std::size_t looks = 2000;
  constexpr double farthest = 2.5;  // spacings; beyond, a particle is a drop of its own
  const double d = model.spacing, full = static_cast<double>(quanta_per_particle);
  PointGrid grid(d);
  for (const StartParticle& p : particles) grid.add(p.position);
  std::vector<double> distance;  // over the edge of the particle's cube
  std::size_t looked = 0, close = 0;
  for (std::size_t i = 0; i < particles.size(); i += std::max<std::size_t>(1, particles.size() / looks)) {
    const Vector3d x = to_eigen(particles[i].position);
    double nearest = farthest * d;
    for (const double reach : {d, farthest * d}) {
      if (nearest < reach) break;
      grid.for_box(to_vec3(x.array() - reach), to_vec3(x.array() + reach), [&](Index p) {
        const auto k = static_cast<std::size_t>(p);
        if (k != i) nearest = std::min(nearest, (to_eigen(particles[k].position) - x).norm());
      });
    }
    ++looked;
    const double edge = d * std::cbrt(static_cast<double>(particles[i].mass) / full);
    if (nearest < 0.5 * edge) ++close;
    if (nearest < farthest * d) distance.push_back(nearest / edge);
  }
  if (2 * distance.size() < looked || distance.empty()) return;  // drops
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  const double share = static_cast<double>(close) / static_cast<double>(looked), median = *middle;
  // Particles at random have a median of 0.55; a lattice at half the spacing has 0.5.
  if (median > 0 && (median < (pushes ? 0.7 : 0.52) || median > 1.5))
    warnings.push_back(fmt::format(
        "{}: its particles are {:.2g} times as far apart (median) as spacing {:g} m and their masses require, so the "
        "liquid has {:.2g} times its density; set spacing to the distance in the file, or write masses",
        name, median, d, std::pow(median, -3)));
  else if (share > 0.05 && (pushes || median == 0))
    warnings.push_back(fmt::format(
        "{}: {:.0f} % of the particles are closer to another one than half of spacing {:g} m and {}; remove copies, or "
        "use a smaller spacing",
        name, 100 * share, d, pushes ? "burst apart at once" : "count twice"));
}

std::vector<StartParticle> start_particles(const Model& model, BlockScene& block, SourceFile file,
                                           const std::string& name) {
  return block.shape == Shape::particles ? placed(model, block, std::move(file.particles), name)
                                         : fill(model, block, std::move(file), name);
}

}  // namespace drench
