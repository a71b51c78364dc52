#include "setup/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/eigen_vec.hpp"
#include "setup/body_geometry.hpp"
#include "setup/cloth_mesh.hpp"
#include "setup/point_grid.hpp"
#include "stages/substeps.hpp"
#include "state/driven_speed.hpp"
#include "state/nozzle.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

/// Distance (m) to the solid that is nearest at t = 0, or less; the answer is exact for distances below
/// `within`. Meshes are exact up to the end of their distance fields; one that is not closed is no obstacle.
double solid_distance(const Model& model, const Vec3& x, double within, const Body** nearest) {
  double distance = INFINITY;
  for (const Body& body : model.bodies) {
    Vec3 normal;
    double here = 0;
    if (body.kind == BodyScene::Kind::mesh) {
      if (body.field.empty()) continue;
      const double outside = (to_eigen(x) - to_eigen(body.center)).norm() - body.reach;
      here = outside > within ? outside : std::min(signed_distance(body, x, normal), within);
    } else {
      here = signed_distance(body, x, normal);
    }
    if (here >= distance) continue;
    distance = here;
    if (nearest) *nearest = &body;
  }
  return distance;
}

/// Is x on a side of the body that looks down, so that it is farther away below x? Then it holds nothing.
bool is_underside(const Body& body, const Vec3& x, const Vector3d& down, double thickness) {
  Vec3 normal;
  const double here = signed_distance(body, x, normal),
               below = signed_distance(body, to_vec3(to_eigen(x) + thickness * down), normal);
  return here > -rounding_of(body) && below > here + 0.1 * thickness;
}

/// Nothing goes on behind it.
bool is_wall(const Body& body) {
  return body.kind == BodyScene::Kind::plane || (body.kind == BodyScene::Kind::box && body.inside);
}

class Paths {
 public:
  explicit Paths(const Model& model) : model_(model), nodes_(std::max(mean_edge_length(model), model.spacing)) {
    for (const Vec3& x : model.mesh.rest_position) {
      nodes_.add(x);
      cloth_.extend(to_eigen(x));
    }
    reach_ = std::max(mean_edge_length(model), model.spacing);
    longest_ = (to_eigen(model.scene.domain.max) - to_eigen(model.scene.domain.min)).norm() / 50;
    patience_ = 1e6 / static_cast<double>(1 + model.bodies.size());  // steps of all paths together
  }

  void follow(const Vec3& from, const Vec3& start, double duration, bool from_cloth) {
    Vector3d x = to_eigen(from), v = to_eigen(start);
    bool touching = true;  // what begins at a solid does not hit it
    for (double t = 0; patience_ > 0; patience_ -= 1) {
      speeds.fastest = std::max(speeds.fastest, v.norm());
      if (!contains(model_.scene.domain.min, model_.scene.domain.max, to_vec3(x))) return;
      const Body* body = nullptr;
      const double solid = solid_distance(model_, to_vec3(x), 2 * model_.spacing, &body);
      if (solid >= model_.spacing) {
        touching = false;
      } else {
        if (!touching) speeds.impact = std::max(speeds.impact, v.norm());
        touching = true;
        Vec3 normal{0, 0, 0};
        if (is_wall(*body) && signed_distance(*body, to_vec3(x), normal) < model_.spacing &&
            to_eigen(normal).dot(v) < -1e-3 * v.norm())
          return;
      }
      double clearance = std::max(solid, 0.0);
      if (!from_cloth && model_.has_cloth()) {
        const double away = cloth_.exteriorDistance(x);
        if (away <= reach_ && nodes_.any_within(to_vec3(x), reach_)) {
          speeds.impact = std::max(speeds.impact, v.norm());
          return;
        }
        clearance = std::min(clearance, std::max(away - reach_, 0.5 * reach_));
      }
      const Vector3d a = acceleration(x);
      const double step = std::clamp(clearance, 0.5 * model_.spacing, std::max(longest_, model_.spacing));
      const double dt = std::min({duration - t, 0.5 * step / v.norm(), std::sqrt(step / a.norm())});
      if (!(dt > 0) || !std::isfinite(dt)) return;
      x += dt * v + 0.5 * dt * dt * a;
      v += 0.5 * dt * (a + acceleration(x));
      t += dt;
    }
  }

  ExpectedSpeeds speeds;

 private:
  Vector3d acceleration(const Vector3d& x) const {
    Vector3d a = to_eigen(model_.scene.gravity);
    if (model_.scene.field.present)
      for (int k = 0; k < 3; ++k) {
        const double rate = model_.scene.field.rate[static_cast<std::size_t>(k)];
        a[k] -= rate * rate * (x[k] - model_.scene.field.center[static_cast<std::size_t>(k)]);
      }
    return a;
  }

  const Model& model_;
  PointGrid nodes_;
  Eigen::AlignedBox3d cloth_;
  double reach_ = 0, longest_ = 0, patience_ = 0;
};

/// Every so many-th, so that about `most` are looked at.
std::size_t stride(std::size_t count, std::size_t most) { return 1 + count / most; }

}  // namespace

ExpectedSpeeds expected_speeds(const Model& model, const HostState& state) {
  Paths paths(model);
  const double end = model.scene.time.end, half = 0.5 * model.spacing;
  const FluidScene& fluid = model.scene.fluid;
  for (std::size_t b = 0; b < fluid.blocks.size(); b += stride(fluid.blocks.size(), 50)) {
    const BlockScene& block = fluid.blocks[b];
    for (int i = 0; i < 27; ++i) {
      Vec3 x;
      for (std::size_t a = 0; a < 3; ++a) {
        const double middle = 0.5 * (block.box.min[a] + block.box.max[a]),
                     reach = std::max(0.0, 0.5 * (block.box.max[a] - block.box.min[a]) - half);
        const int at = a == 0 ? i % 3 : a == 1 ? i / 3 % 3 : i / 9;
        x[a] = middle + (at - 1) * reach;
      }
      if (solid_distance(model, x, model.spacing, nullptr) >= 0)  // particles in solids are left out
        paths.follow(x, block.velocity, end, false);
    }
    paths.speeds.impact = std::max(paths.speeds.impact, to_eigen(block.velocity).norm());
  }
  for (std::size_t i = 0; i < state.fluid_position.size(); i += stride(state.fluid_position.size(), 40))
    paths.follow(state.fluid_position[i], state.fluid_velocity[i], end, false);
  for (const Vec3& v : state.fluid_velocity) paths.speeds.impact = std::max(paths.speeds.impact, to_eigen(v).norm());
  for (std::size_t j = 0; j < model.jets.size(); j += stride(model.jets.size(), 50)) {
    const JetScene& jet = model.jets[j].scene;
    if (jet.start >= end) continue;
    if (model.jets[j].mouth) {
      constexpr std::int64_t particles = 5;
      for (const double time : times_of_mouth(model.jets[j], end))
        for (std::int64_t k = 0; k < particles; ++k) {
          const Leaving particle = leaving_particle(model.jets[j], k, time);
          paths.follow(particle.position, particle.velocity, end - time, false);
        }
      paths.speeds.impact = std::max(paths.speeds.impact, fastest_leaving(model.jets[j]));
      continue;
    }
    if (!jet.velocity.has_keys()) paths.follow(jet.center, jet.velocity.plain(), end - jet.start, false);
    for (const Key<Vec3>& key : jet.velocity.keys())
      paths.follow(jet.center, key.value, std::max(0.0, end - std::max(jet.start, key.time)), false);
    paths.speeds.impact = std::max(paths.speeds.impact, jet.velocity.largest());
  }
  if (model.has_emission())
    for (const ClothMaterial& cloth : model.cloths)
      for (Index n = 0; cloth.porous && n < cloth.node_count;
           n += static_cast<Index>(stride(static_cast<std::size_t>(cloth.node_count), 20)))
        paths.follow(state.node_position[static_cast<std::size_t>(cloth.first_node + n)], {0, 0, 0}, end, true);
  ExpectedSpeeds speeds = paths.speeds;
  const double driven = model.has_fluid() ? driven_speed(model) : 0;
  speeds.impact = std::max(speeds.impact, driven);
  speeds.fastest = std::max(speeds.fastest, speeds.impact);
  return speeds;
}

bool falls_freely(const Model& model, const ClothMaterial& cloth, const std::vector<Index>& nodes) {
  const Vector3d g = to_eigen(model.scene.gravity);
  if (!cloth.dynamics || g.norm() == 0 || model.has_moving_body()) return false;
  for (const Index n : nodes)
    if (model.mesh.pinned[static_cast<std::size_t>(n)] || model.mesh.soft_pin(n) > 0) return false;
  if (cloth.self_collision)
    for (const ClothMaterial& other : model.cloths)
      if (&other != &cloth && other.self_collision) return false;
  const Vector3d down = g.normalized();
  const Box& domain = model.scene.domain;
  const double within = std::max(2 * model.spacing, cloth.thickness),
               shortest = 1e-4 * (to_eigen(domain.max) - to_eigen(domain.min)).norm();
  for (std::size_t k = 0; k < nodes.size(); k += stride(nodes.size(), 100)) {
    Vector3d x = to_eigen(model.mesh.rest_position[static_cast<std::size_t>(nodes[k])]);
    while (contains(domain.min, domain.max, to_vec3(x))) {
      const Body* body = nullptr;
      const double distance = solid_distance(model, to_vec3(x), within, &body);
      if (distance < 1.1 * cloth.thickness && !is_underside(*body, to_vec3(x), down, cloth.thickness)) return false;
      if (!std::isfinite(distance)) break;
      x += std::max({distance - cloth.thickness, 0.5 * cloth.thickness, shortest}) * down;
    }
  }
  return true;
}

bool falls_freely(const Model& model, const ClothMaterial& cloth) {
  std::vector<Index> nodes(static_cast<std::size_t>(cloth.node_count));
  std::iota(nodes.begin(), nodes.end(), cloth.first_node);
  return falls_freely(model, cloth, nodes);
}

double height_in_domain(const Model& model, const ClothMaterial& cloth) {
  const Vector3d g = to_eigen(model.scene.gravity);
  const Box& domain = model.scene.domain;
  double height = 0;
  for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
    const Vec3& x = model.mesh.rest_position[static_cast<std::size_t>(n)];
    double own = INFINITY;
    for (std::size_t a = 0; a < 3; ++a) {
      const double along = model.scene.gravity[a] / g.norm();
      if (along == 0) continue;
      own = std::min(own, std::max(0.0, ((along > 0 ? domain.max[a] : domain.min[a]) - x[a]) / along));
    }
    height = std::max(height, own);
  }
  return height;
}

double diffusion_rate(const Model& model, const ClothMaterial& cloth) {
  const FabricPairs& fabric = model.fabric;
  const double load = model.rest_density * (1 - cloth.solid_fraction) * cloth.thickness;
  const double most =
      mobility_bound(cloth.diffusion_exponent, cloth.pore_saturation(), RetentionShape(cloth)).difference;
  double fastest = 0;
  for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    double sum = 0;
    for (Index k = fabric.of_node.start[at]; k < fabric.of_node.start[at + 1]; ++k)
      sum += fabric.weight[static_cast<std::size_t>(fabric.of_node.item[static_cast<std::size_t>(k)] / 2)];
    if (model.samples.node_capacity[at] > 0)
      fastest = std::max(fastest, most * load * cloth.diffusivity * sum / model.samples.node_capacity[at]);
  }
  return fastest;
}

ClothIterations cloth_iterations(const Model& model, const ClothMaterial& cloth, double dt) {
  if (!cloth.dynamics) return {};
  const ClothMesh& mesh = model.mesh;
  // D_n − m_n/Δt², without strain limits, which act at times
  std::vector<double> springs(mesh.solid_mass.size(), 0.0), hinges = springs;
  for (std::size_t e = 0; e < mesh.edge.size(); ++e)
    for (const Index n : mesh.edge[e]) springs[static_cast<std::size_t>(n)] += mesh.edge_stiffness[e];
  for (std::size_t k = 0; k < mesh.stitch.size(); ++k)
    for (const Index n : mesh.stitch[k]) springs[static_cast<std::size_t>(n)] += mesh.stitch_stiffness[k];
  for (std::size_t h = 0; h < mesh.hinge.size(); ++h) {
    double sum = 0;
    for (const double k : mesh.hinge_weight[h]) sum += std::abs(k);
    for (std::size_t a = 0; a < 4; ++a)
      hinges[static_cast<std::size_t>(mesh.hinge[h][a])] +=
          0.5 * mesh.hinge_stiffness[h] * std::abs(mesh.hinge_weight[h][a]) * sum;
  }
  for (std::size_t t = 0; t < mesh.membrane.size(); ++t) {  // Eq. 15 of docs/theory/cloth.md
    const auto [xx, xy, yy] = mesh.triangle_shape[t];
    const Membrane<double>& m = mesh.membrane[t];
    const double x[3] = {std::abs(xx), std::abs(xx), 0}, y[3] = {std::abs(xy + yy), std::abs(xy), std::abs(yy)};
    for (std::size_t a = 0; a < 3; ++a)
      springs[static_cast<std::size_t>(mesh.triangle[t][a])] +=
          0.5 * (std::max(m.warp, m.weft) + 2 * m.shear) * (x[a] * (x[0] + x[1]) + y[a] * (y[0] + y[1] + y[2]));
  }
  for (std::size_t k = 0; k < mesh.plate_pair.size(); ++k)
    for (const Index n : mesh.plate_pair[k])
      hinges[static_cast<std::size_t>(n)] += std::max(0.0, -mesh.plate_weight[k]);
  const auto scene = std::find_if(model.scene.cloths.begin(), model.scene.cloths.end(),
                                  [&](const ClothScene& c) { return c.name == cloth.name; });
  const bool known = scene != model.scene.cloths.end();
  const char* const stretching = known && scene->material.membrane ? "membrane" : "stretch";
  const char* const bending = known && scene->material.bending ? "bending" : "bend";
  const double damped = cloth.strain_damping / dt;
  ClothIterations found;
  double slowest = 0;  // ρ/(1 − ρ) = Δt² (D_n − m_n/Δt²)/m_n at most
  for (Index n = cloth.first_node; n < cloth.first_node + cloth.node_count; ++n) {
    const auto at = static_cast<std::size_t>(n);
    if (mesh.pinned[at]) continue;
    const double slow = dt * dt * (springs[at] * (1 + damped) + hinges[at]) / mesh.solid_mass[at];
    if (!(slow > slowest)) continue;
    slowest = slow;
    found.cause = hinges[at] > springs[at] * (1 + damped) ? bending : damped > 1 ? "strain_damping" : stretching;
  }
  if (slowest > 0)
    found.count =
        std::log(2 / model.scene.cloth_solver.tolerance) / std::log1p((1 + std::sqrt(1 + 2 * slowest)) / slowest);
  return found;
}

double viscous_passes(const Model& model, double dt) {
  const double bound = 3 * 30 * model.scene.fluid.viscosity / (model.support * model.support);
  return std::ceil(std::sqrt(0.25 + 2 * dt * bound) - 0.5);
}

double spin_passes(const Model& model, double dt) {
  const MicropolarScene& spin = model.scene.fluid.micropolar;
  const double h = model.support, inertia = spin.inertia * model.spacing * model.spacing;
  const double bound = spin.transfer / 2 * (144 / (h * h) + 9 / inertia) + 2 * 6 * spin.viscosity / (h * h) * 3;
  return std::ceil(std::sqrt(0.25 + dt * bound) - 0.5);
}

}  // namespace drench
