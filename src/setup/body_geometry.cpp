#include "setup/body_geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "base/eigen_vec.hpp"
#include "setup/distance_field.hpp"
#include "setup/file_place.hpp"
#include "setup/mesh_io.hpp"
#include "setup/mesh_moments.hpp"
#include "setup/mesh_sequence.hpp"
#include "setup/setup_error.hpp"
#include "setup/solid_mesh.hpp"
#include "state/keyed_motion.hpp"

namespace drench {
namespace {

Vec3 unit(const Vec3& v, const std::string& what) {
  const double length = to_eigen(v).norm();
  if (!(length > 0) || !std::isfinite(length)) throw SetupError(what + " must not be zero");
  return to_vec3(to_eigen(v) / length);
}

/// Distance to a solid box, and its gradient.
double box_distance(const Box& box, const Vec3& x, Eigen::Vector3d& normal) {
  const Eigen::Vector3d lo = to_eigen(box.min), hi = to_eigen(box.max);
  const Eigen::Vector3d local = to_eigen(x) - 0.5 * (lo + hi);
  const Eigen::Vector3d beyond = local.cwiseAbs() - 0.5 * (hi - lo);
  int axis = 0;
  if (beyond.maxCoeff(&axis) > 0) {
    const Eigen::Vector3d out = beyond.cwiseMax(0.0);
    const double distance = out.norm();
    normal = out / distance;
    for (int a = 0; a < 3; ++a) normal[a] = std::copysign(normal[a], local[a]);
    return distance;
  }
  normal = Eigen::Vector3d::Zero();
  normal[axis] = std::copysign(1.0, local[axis]);
  return beyond[axis];
}

}  // namespace

double signed_distance(const Body& body, const Vec3& x, Vec3& normal) {
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  double distance = 0;
  switch (body.kind) {
    case BodyScene::Kind::box:
      distance = box_distance(body.box, x, n);
      if (body.inside) {
        distance = -distance;
        n = -n;
      }
      break;
    case BodyScene::Kind::sphere: {
      n = to_eigen(x) - to_eigen(body.center);
      const double r = n.norm();
      n = r > 0 ? Eigen::Vector3d(n / r) : Eigen::Vector3d::UnitY();
      distance = r - body.radius;
      break;
    }
    case BodyScene::Kind::plane:
      n = to_eigen(body.normal);
      distance = n.dot(to_eigen(x) - to_eigen(body.point));
      break;
    case BodyScene::Kind::mesh:
      return field_distance(body.field, x, normal);
  }
  normal = to_vec3(n);
  return distance;
}

double rounding_of(const Body& body) { return 1e-6 * body.reach; }

std::string body_label(const std::string& name, std::size_t index) {
  return name.empty() ? fmt::format("bodies.{}", index) : fmt::format("body '{}'", name);
}

std::string body_labels(const std::vector<Body>& bodies, const std::set<std::size_t>& indices) {
  constexpr std::size_t most = 4;
  std::string text;
  std::size_t k = 0;
  for (const std::size_t index : indices) {
    if (k == most) return text + fmt::format(" and {} more", indices.size() - most);
    text += (k++ > 0 ? ", " : "") + body_label(bodies[index].name, index);
  }
  return text;
}

namespace {

/// Of a homogeneous closed mesh, which from now on turns about its centre of mass.
void weigh_mesh(Body& body, double density, const std::optional<double>& mass, const std::string& name) {
  if (!bounds_solid(body.mesh_triangles))
    throw SetupError(name +
                     ": a mesh that encloses no volume cannot be dynamic; allowed: a mesh that encloses a volume");
  const MeshMoments moments = moments_of(body.mesh_points, body.mesh_triangles, body.center);
  if (!(moments.volume > 1e-9 * std::pow(body.reach, 3)))
    throw SetupError(fmt::format(
        "{}: its mesh encloses {:.2g} m³, too little for a dynamic body; allowed: a mesh that encloses a volume", name,
        moments.volume));
  body.center = to_vec3(moments.center);
  body.reach = 0;
  for (const Vec3& x : body.mesh_points) body.reach = std::max(body.reach, (to_eigen(x) - moments.center).norm());
  const double rho = mass ? *mass / moments.volume : density;
  body.mass = rho * moments.volume;
  const Eigen::Matrix3d inertia = rho * (moments.second.trace() * Eigen::Matrix3d::Identity() - moments.second);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
  Eigen::Matrix3d turn = axes.eigenvectors();
  if (turn.determinant() < 0) turn.col(0) *= -1;
  const Eigen::Quaterniond q(turn);
  body.principal = {q.w(), q.x(), q.y(), q.z()};
  body.inertia = to_vec3(axes.eigenvalues());
}

/// Mass and principal moments of inertia of a homogeneous sphere or box.
void weigh_shape(Body& body, double density) {
  if (body.kind == BodyScene::Kind::sphere) {
    body.mass = density * 4 / 3 * std::numbers::pi * std::pow(body.radius, 3);
    body.inertia.fill(0.4 * body.mass * body.radius * body.radius);
    return;
  }
  const Eigen::Vector3d size = to_eigen(body.box.max) - to_eigen(body.box.min);
  body.mass = density * size.prod();
  for (int a = 0; a < 3; ++a) body.inertia[a] = body.mass / 12 * (size.squaredNorm() - size[a] * size[a]);
}

void weigh(Body& body, const BodyScene& scene, const std::string& name) {
  if (body.kind == BodyScene::Kind::mesh) return weigh_mesh(body, scene.density, scene.mass, name);
  weigh_shape(body, scene.density);
  if (!scene.mass) return;
  for (double& i : body.inertia) i *= *scene.mass / body.mass;
  body.mass = *scene.mass;
}

/// The value without keys if it is 0 at each of them, so that a body has keys only if it moves.
template <class T>
Keyed<T> plain_if_zero(const Keyed<T>& value) {
  return value.is_zero() ? Keyed<T>() : value;
}

std::string place_of(const MeshHole& hole) {
  return fmt::format("{:.3g} m across at ({:.4g}, {:.4g}, {:.4g})", hole.width, hole.center[0], hole.center[1],
                     hole.center[2]);
}

/// What becomes of a mesh with holes. `size` (m): the longest side of the mesh.
const char* fate_of_holes(const SolidMesh& solid, MeshUse use, double size) {
  constexpr double large = 0.2;  // of the size: liquid is likely meant to enter
  if (use == MeshUse::liquid) return "holes are closed, and the volume inside is filled";
  if (solid.holes.front().width < large * size)
    return solid.holes.size() > 1 ? "they are small and are closed; the inside is solid"
                                  : "it is small and is closed; the inside is solid";
  if (use == MeshUse::solid) return "holes are closed and the inside is solid; a vessel needs walls with a thickness";
  return "holes are closed and the inside is solid; for a vessel that liquid enters set `inside: true`, which makes it "
         "a thin wall";
}

/// Lines about what a solid's mesh is not. `label`: of the body and its file.
void report(const SolidMesh& solid, MeshUse use, double size, const std::string& label,
            std::vector<std::string>& lines) {
  if (!solid.holes.empty())
    lines.push_back(fmt::format("{}: the mesh has {} hole{} {}: {}", label, solid.holes.size(),
                                solid.holes.size() > 1 ? "s, the largest" : ",", place_of(solid.holes.front()),
                                fate_of_holes(solid, use, size)));
  if (solid.joined > 0)
    lines.push_back(
        fmt::format("{}: it is made of patches without common points along their edges, which are joined{}", label,
                    solid.gap > 1e-6 * size ? fmt::format(" across gaps of up to {:.2g} m", solid.gap) : ""));
  if (solid.branches > 0)
    lines.push_back(fmt::format(
        "{}: more than two triangles share {} of its edges, the first at ({:.4g}, {:.4g}, {:.4g}): the volume that its "
        "outer surface encloses is {}",
        label, solid.branches, solid.branch[0], solid.branch[1], solid.branch[2],
        use == MeshUse::liquid ? "filled" : "solid"));
  if (solid.left_out > 0)
    lines.push_back(fmt::format(
        "{}: {} to sheets that enclose no volume and {} omitted, because deforming bodies must be closed", label,
        solid.left_out == 1 ? "1 triangle belongs" : fmt::format("{} triangles belong", solid.left_out),
        solid.left_out == 1 ? "is" : "are"));
}

/// The body's mesh as its file has it, in m.
SurfaceMesh placed_mesh(const BodyScene& scene, const std::string& scene_path, const std::string& label) {
  SurfaceMesh mesh = read_mesh(scene.file, scene_path, {}, scene.sequence);
  file_place(scene)(mesh.points);
  check_points(mesh.points, label);
  return mesh;
}

/// A box that is turned is a mesh, and an ellipsoid is one.
bool becomes_mesh(const BodyScene& scene) {
  const Vec3& by = scene.stretch;
  return (scene.kind == BodyScene::Kind::box && scene.rotate_degrees != 0) ||
         (scene.kind == BodyScene::Kind::sphere && (by[0] != by[1] || by[0] != by[2]));
}

/// Scales and turns about `middle`, then moves.
void put_in_place(const BodyScene& scene, const Eigen::Vector3d& middle, std::vector<Vec3>& points) {
  const Eigen::Matrix3d linear =
      rotation_about(scene.rotate_axis, scene.rotate_degrees) * Eigen::Matrix3d(to_eigen(scene.stretch).asDiagonal());
  for (Vec3& x : points) x = to_vec3(middle + linear * (to_eigen(x) - middle) + to_eigen(scene.place));
}

/// Its corners and faces in their place.
SurfaceMesh turned_box(const BodyScene& scene) {
  const Eigen::Vector3d low = to_eigen(scene.box.min), high = to_eigen(scene.box.max);
  SurfaceMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d x;
    for (int a = 0; a < 3; ++a) x[a] = (corner >> a & 1) ? high[a] : low[a];
    mesh.points.push_back(to_vec3(x));
  }
  put_in_place(scene, 0.5 * (low + high), mesh.points);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// The faces of an octahedron, each cut into `cuts`² and brought out onto the sphere; then in their place. The mesh
/// holds 0.3 % less than the ellipsoid.
SurfaceMesh ellipsoid(const BodyScene& scene) {
  constexpr int cuts = 24;
  SurfaceMesh mesh;
  std::map<std::array<int, 3>, Index> number;  // of points of the octahedron |x| + |y| + |z| = cuts
  const auto point = [&](const std::array<int, 3>& x) {
    const auto [found, fresh] = number.try_emplace(x, static_cast<Index>(mesh.points.size()));
    if (fresh) {
      // By angles along the edges, so that faces at the corners are not smaller than those in the middle.
      Eigen::Vector3d on;
      for (int a = 0; a < 3; ++a) on[a] = std::sin(0.5 * std::numbers::pi * x[static_cast<std::size_t>(a)] / cuts);
      mesh.points.push_back(to_vec3(to_eigen(scene.center) + scene.radius * on.normalized()));
    }
    return found->second;
  };
  for (const int sx : {-1, 1})
    for (const int sy : {-1, 1})
      for (const int sz : {-1, 1}) {
        const bool turned = sx * sy * sz < 0;
        const auto face = [&](const std::array<int, 3>& a, const std::array<int, 3>& b, const std::array<int, 3>& c) {
          const Index i = point(a), j = point(b), k = point(c);
          mesh.triangles.push_back(turned ? std::array<Index, 3>{i, k, j} : std::array<Index, 3>{i, j, k});
        };
        const auto at = [&](int i, int j) { return std::array<int, 3>{sx * i, sy * j, sz * (cuts - i - j)}; };
        for (int i = 0; i < cuts; ++i)
          for (int j = 0; i + j < cuts; ++j) {
            face(at(i, j), at(i + 1, j), at(i, j + 1));
            if (i + j + 1 < cuts) face(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
          }
      }
  put_in_place(scene, to_eigen(scene.center), mesh.points);
  return mesh;
}

/// A box, a sphere or a plane that keeps its kind, in its place.
BodyScene placed_shape(BodyScene scene) {
  if (scene.kind == BodyScene::Kind::mesh || becomes_mesh(scene)) return scene;
  for (std::size_t a = 0; a < 3; ++a) {
    const double middle = 0.5 * (scene.box.min[a] + scene.box.max[a]);
    for (double* side : {&scene.box.min[a], &scene.box.max[a]}) {
      if (scene.stretch[a] != 1) *side = middle + scene.stretch[a] * (*side - middle);
      *side += scene.place[a];
    }
    scene.center[a] += scene.place[a];
    scene.point[a] += scene.place[a];
  }
  scene.radius *= scene.stretch[0];
  if (scene.rotate_degrees != 0)
    scene.normal = to_vec3(rotation_about(scene.rotate_axis, scene.rotate_degrees) * to_eigen(scene.normal));
  return scene;
}

Sheets sheets_of(const BodyScene& scene) { return scene.sequence.files.empty() ? Sheets::keep : Sheets::leave_out; }

/// Of each point of the body's mesh: the file's point that it is.
std::vector<Index> read_body_mesh(Body& body, const BodyScene& scene, const std::string& scene_path,
                                  const std::string& name, MeshUse use, std::vector<std::string>& warnings) {
  const bool of_file = scene.kind == BodyScene::Kind::mesh;
  const std::string label = of_file ? fmt::format("{} ({})", name, scene.file) : name;
  const SurfaceMesh mesh = of_file                                 ? placed_mesh(scene, scene_path, label)
                           : scene.kind == BodyScene::Kind::sphere ? ellipsoid(scene)
                                                                   : turned_box(scene);
  if (!mesh.left_out.empty()) warnings.push_back(fmt::format("{}: {}", name, mesh.left_out));
  SolidMesh solid = close_mesh(mesh, sheets_of(scene));
  const bool has_inside = !scene.inside && solid.has_inside();
  if (!has_inside) {
    solid.triangles = mesh.triangles;
    solid.source.resize(mesh.points.size());
    std::iota(solid.source.begin(), solid.source.end(), Index{0});
    warnings.push_back(fmt::format("{}: {}: only the boundary particles on its surface hold liquid back", label,
                                   scene.inside ? "a thin wall" : "it encloses no volume"));
  }
  Eigen::AlignedBox3d bounds;
  for (const Index i : solid.source) {
    body.mesh_points.push_back(mesh.points[static_cast<std::size_t>(i)]);
    bounds.extend(to_eigen(body.mesh_points.back()));
  }
  if (has_inside) report(solid, use, bounds.sizes().maxCoeff(), label, warnings);
  body.center = to_vec3(bounds.center());
  for (const Vec3& x : body.mesh_points) body.reach = std::max(body.reach, (to_eigen(x) - bounds.center()).norm());
  body.mesh_triangles = std::move(solid.triangles);
  return std::move(solid.source);
}

}  // namespace

TextureCorners body_texture(const BodyScene& scene, const std::string& scene_path, std::size_t& untextured) {
  SurfaceMesh mesh = read_mesh(scene.file, scene_path, {.texture = true}, scene.sequence);
  untextured = mesh.untextured;
  const SolidMesh solid = close_mesh(mesh, sheets_of(scene));
  if (mesh.texture.empty() || scene.inside || !solid.has_inside()) return std::move(mesh.texture);
  const auto sorted = [](std::array<Index, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  std::map<std::array<Index, 3>, std::size_t> number;  // of copies, the first is the body's
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) number.try_emplace(sorted(mesh.triangles[t]), t);
  TextureCorners turned;
  for (const auto& t : solid.triangles) {
    std::array<Index, 3> own{};
    for (std::size_t c = 0; c < 3; ++c) own[c] = solid.source[static_cast<std::size_t>(t[c])];
    const auto found = number.find(sorted(own));
    if (found == number.end()) break;  // those that cover holes come last
    turned.emplace_back();
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k)
        if (mesh.triangles[found->second][k] == own[c]) turned.back()[c] = mesh.texture[found->second][k];
  }
  return turned;
}

void refuse_thin_wall(const Body& body, const BodyScene& scene, const std::string& name) {
  const std::string label = fmt::format("{} ({})", name, scene.file);
  const SolidMesh solid = close_mesh({body.mesh_points, body.mesh_triangles});
  if (scene.inside)
    throw SetupError(label +
                     ": moving cloth cannot touch a mesh with inside: true, a thin wall; allowed: a mesh without that "
                     "key whose walls have a thickness, or cloths with dynamics: false");
  throw SetupError(fmt::format(
      "{}: moving cloth cannot touch a mesh that encloses no volume{}; allowed: a mesh that encloses a volume "
      "(give the sheet a thickness, or close it), a box, sphere or plane, or cloths with dynamics: false",
      label,
      solid.holes.empty() ? "" : fmt::format(": its edge, {}, surrounds all of it", place_of(solid.holes.front()))));
}

Body make_body(const BodyScene& given, const std::string& scene_path, const std::string& name,
               std::vector<std::string>* warnings, MeshUse use) {
  const BodyScene scene = placed_shape(given);
  Body body;
  std::vector<std::string> lines;
  std::vector<Index> source;  // of a mesh's points
  body.name = scene.name;
  body.kind = becomes_mesh(scene) ? BodyScene::Kind::mesh : scene.kind;
  body.box = scene.box;
  body.inside = scene.inside && scene.kind == BodyScene::Kind::box;
  body.center = scene.center;
  body.radius = scene.radius;
  body.point = scene.point;
  body.adhesion = scene.adhesion;
  body.slip = scene.slip;
  switch (body.kind) {
    case BodyScene::Kind::box:
      for (int a = 0; a < 3; ++a) {
        if (!(scene.box.max[a] > scene.box.min[a]))
          throw SetupError(name + ": max must be greater than min on each axis");
        body.center[a] = 0.5 * (body.box.min[a] + body.box.max[a]);
      }
      body.reach = 0.5 * (to_eigen(scene.box.max) - to_eigen(scene.box.min)).norm();
      break;
    case BodyScene::Kind::sphere:
      if (!(scene.radius > 0)) throw SetupError(name + ": the radius must be positive");
      body.reach = scene.radius;
      break;
    case BodyScene::Kind::plane:
      body.normal = unit(scene.normal, name + ": the normal");
      body.center = scene.point;  // its reach depends on the domain
      break;
    case BodyScene::Kind::mesh:
      if (scene.dynamic || !scene.sequence.files.empty()) use = MeshUse::solid;
      source = read_body_mesh(body, scene, scene_path, name, use, lines);
      break;
  }
  body.velocity = plain_if_zero(scene.velocity);
  body.path = plain_if_zero(scene.offset);
  if (!scene.spin.degrees_per_second.is_zero()) {
    body.spin_axis = unit(scene.spin.axis, name + ": the axis of spin");
    body.spin_rate = scene.spin.degrees_per_second.scaled(std::numbers::pi / 180);
  }
  if (!scene.sequence.files.empty()) follow_sequence(body, scene, scene_path, name, source);
  if (body.deforms() && scene.inside)
    throw SetupError(name +
                     ": a mesh with inside: true cannot deform; allowed: no inside, or a mesh that moves rigidly");
  body.commanded = scene.commanded;
  body.dynamic = scene.dynamic;
  body.friction = scene.friction;
  body.restitution = scene.restitution;
  if (scene.dynamic) weigh(body, scene, name);
  if (warnings) warnings->insert(warnings->end(), lines.begin(), lines.end());
  return body;
}

Vec3 body_velocity(const Body& body, const Vec3& x) {
  const Eigen::Vector3d arm = to_eigen(x) - to_eigen(body.center);
  return to_vec3(to_eigen(velocity_at(body, 0)) + to_eigen(spin_between(body, 0, 0)).cross(arm));
}

void start_bodies(const Model& model, HostState& state) {
  state.body_position.clear();
  state.body_velocity.clear();
  state.body_angular_velocity.clear();
  for (const Body& body : model.bodies) {
    state.body_position.push_back(body.center);
    state.body_velocity.push_back(velocity_at(body, 0));
    state.body_angular_velocity.push_back(spin_between(body, 0, 0));
  }
  state.body_orientation.assign(model.bodies.size(), Quaternion{1, 0, 0, 0});
}

Vec3 placed_point(const Body& body, const HostState& state, Index index, const Vec3& x) {
  const auto& q = state.body_orientation[static_cast<std::size_t>(index)];
  const Eigen::Vector3d arm = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * (to_eigen(x) - to_eigen(body.center));
  return to_vec3(to_eigen(state.body_position[static_cast<std::size_t>(index)]) + arm);
}

}  // namespace drench
