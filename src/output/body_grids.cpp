// The bodies' surfaces for the picture: analytic shapes become meshes, and all lie where the run has them.

#include <vtkCellData.h>
#include <vtkIntArray.h>
#include <vtkPolyData.h>
#include <vtkSphereSource.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "output/grid_tools.hpp"
#include "setup/body_geometry.hpp"
#include "state/deforming_body.hpp"

namespace drench {
namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Polygons of several bodies under construction.
struct Surface {
  std::vector<Vec3> points;
  std::vector<std::vector<vtkIdType>> polygons;
  std::vector<int> body;

  void add(int body_index, const std::vector<Vec3>& new_points, std::vector<std::vector<vtkIdType>> new_polygons) {
    const auto first = static_cast<vtkIdType>(points.size());
    points.insert(points.end(), new_points.begin(), new_points.end());
    for (auto& polygon : new_polygons) {
      for (vtkIdType& p : polygon) p += first;
      polygons.push_back(std::move(polygon));
      body.push_back(body_index);
    }
  }
};

/// Points of a body at t = 0 → where they are now.
struct Placing {
  const Body& body;
  const HostState* state;  // none: at t = 0
  Index index;
  std::vector<Vec3> operator()(std::vector<Vec3> points) const {
    if (state && body.deforms()) return points_at(body.shape, state->time);
    if (state)
      for (Vec3& x : points) x = placed_point(body, *state, index, x);
    return points;
  }
};

/// Corner k of a box: bit 0 of k is x, bit 1 y, bit 2 z.
std::vector<Vec3> corners_of(const Box& box) {
  std::vector<Vec3> corners(8);
  for (std::size_t k = 0; k < 8; ++k)
    for (std::size_t c = 0; c < 3; ++c) corners[k][c] = (k >> c & 1) ? box.max[c] : box.min[c];
  return corners;
}

void add_box(Surface& surface, int index, const Body& body, const Placing& placed) {
  surface.add(index, placed(corners_of(body.box)),
              {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
}

void add_sphere(Surface& surface, int index, const Body& body, const Placing& placed) {
  vtkNew<vtkSphereSource> source;
  source->SetCenter(body.center[0], body.center[1], body.center[2]);
  source->SetRadius(body.radius);
  source->SetThetaResolution(48);
  source->SetPhiResolution(24);
  source->Update();
  vtkPolyData* mesh = source->GetOutput();
  std::vector<Vec3> points(static_cast<std::size_t>(mesh->GetNumberOfPoints()));
  for (std::size_t i = 0; i < points.size(); ++i) mesh->GetPoint(static_cast<vtkIdType>(i), points[i].data());
  std::vector<std::vector<vtkIdType>> polygons;
  for (vtkIdType c = 0; c < mesh->GetNumberOfCells(); ++c) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    mesh->GetCellPoints(c, size, ids);
    polygons.emplace_back(ids, ids + size);
  }
  surface.add(index, placed(points), std::move(polygons));
}

/// The part of the plane that lies in the domain: a convex polygon of 3 to 6 corners, or nothing.
void add_plane(Surface& surface, int index, const Body& body, const Box& domain) {
  const auto corners = corners_of(domain);
  const Vec3 diagonal = minus(domain.max, domain.min);
  const double tolerance = 1e-9 * std::sqrt(dot(diagonal, diagonal));
  std::array<double, 8> height{};
  for (std::size_t k = 0; k < 8; ++k) {
    height[k] = dot(minus(corners[k], body.point), body.normal);
    if (std::abs(height[k]) < tolerance) height[k] = 0;
  }
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < 8; ++k)
    if (height[k] == 0) points.push_back(corners[k]);
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t b = a | (std::size_t{1} << axis);
      if (b == a || height[a] * height[b] >= 0) continue;
      const double t = height[a] / (height[a] - height[b]);
      Vec3 p = corners[a];
      p[axis] += t * (corners[b][axis] - corners[a][axis]);
      points.push_back(p);
    }
  if (points.size() < 3) return;
  Vec3 centre{0, 0, 0};
  for (const Vec3& p : points)
    for (std::size_t c = 0; c < 3; ++c) centre[c] += p[c] / static_cast<double>(points.size());
  const Vec3 u = minus(points[0], centre), v = cross(body.normal, u);
  std::sort(points.begin(), points.end(), [&](const Vec3& p, const Vec3& q) {
    const auto angle = [&](const Vec3& x) { return std::atan2(dot(minus(x, centre), v), dot(minus(x, centre), u)); };
    return angle(p) < angle(q);
  });
  std::vector<vtkIdType> polygon(points.size());
  for (std::size_t i = 0; i < polygon.size(); ++i) polygon[i] = static_cast<vtkIdType>(i);
  surface.add(index, points, {polygon});
}

void add_mesh(Surface& surface, int index, const Body& body, const Placing& placed) {
  std::vector<std::vector<vtkIdType>> polygons;
  for (const auto& t : body.mesh_triangles) polygons.push_back({t[0], t[1], t[2]});
  surface.add(index, placed(body.mesh_points), std::move(polygons));
}

/// The plane as it lies now: through the centre, normal to the turned normal.
Body placed_plane(const Body& body, const Placing& placed) {
  Body plane = body;
  const auto two = placed(
      {body.point, {body.point[0] + body.normal[0], body.point[1] + body.normal[1], body.point[2] + body.normal[2]}});
  plane.point = two[0];
  plane.normal = minus(two[1], two[0]);
  return plane;
}

}  // namespace

Grid bodies_grid(const Model& model, const HostState* state) {
  Surface surface;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const int index = static_cast<int>(i);
    if (body.moves() != (state != nullptr)) continue;
    const Placing placed{body, state, static_cast<Index>(i)};
    switch (body.kind) {
      case BodyScene::Kind::box:
        add_box(surface, index, body, placed);
        break;
      case BodyScene::Kind::sphere:
        add_sphere(surface, index, body, placed);
        break;
      case BodyScene::Kind::plane:
        add_plane(surface, index, placed_plane(body, placed), model.scene.domain);
        break;
      case BodyScene::Kind::mesh:
        add_mesh(surface, index, body, placed);
        break;
    }
  }
  auto grid = Grid::New();
  grid->SetPoints(make_points(surface.points));
  vtkNew<vtkCellArray> cells;
  for (const auto& polygon : surface.polygons)
    cells->InsertNextCell(static_cast<vtkIdType>(polygon.size()), polygon.data());
  grid->SetCells(VTK_POLYGON, cells);
  const std::size_t n = surface.polygons.size();
  add_field<vtkIntArray>(grid->GetCellData(), "body", n, [&](std::size_t k) { return surface.body[k]; });
  add_field<vtkIntArray>(grid->GetCellData(), "container", n, [&](std::size_t k) {
    return model.bodies[static_cast<std::size_t>(surface.body[k])].inside ? 1 : 0;
  });
  add_field<vtkIntArray>(grid->GetCellData(), "plane", n, [&](std::size_t k) {
    return model.bodies[static_cast<std::size_t>(surface.body[k])].kind == BodyScene::Kind::plane ? 1 : 0;
  });
  return grid;
}

}  // namespace drench
