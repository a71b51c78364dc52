#include "output/liquid_surface.hpp"

#include <vtkFloatArray.h>
#include <vtkGenericCell.h>
#include <vtkMarchingCubesTriangleCases.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "base/eigen_vec.hpp"
#include "base/for_ranges.hpp"
#include "output/grid_tools.hpp"
#include "output/liquid_field.hpp"
#include "setup/body_geometry.hpp"
#include "setup/surface_mesh.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double level = 0.5;

/// A cell's corners and edges in the order of VTK's table: an edge begins at a corner and goes along an axis.
constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
constexpr int edge_corner[12] = {0, 1, 3, 0, 4, 5, 7, 4, 0, 1, 3, 2};
constexpr int edge_axis[12] = {0, 1, 0, 1, 0, 1, 0, 1, 2, 2, 2, 2};

/// An edge of the lattice: the indices of the vertex that it begins at, and its axis.
struct LatticeEdge {
  std::array<std::int64_t, 3> vertex;
  std::int64_t axis;
  bool operator==(const LatticeEdge&) const = default;
};

struct LatticeEdgeHash {
  std::size_t operator()(const LatticeEdge& e) const {
    std::uint64_t h = static_cast<std::uint64_t>(e.axis);
    for (const std::int64_t i : e.vertex) h = (h ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15U;
    return h ^ (h >> 32);
  }
};

/// Marching cubes over blocks that share their points.
class Contour {
 public:
  explicit Contour(const LiquidField& field) : step_(field.step()) {
    field.for_blocks([this](const LiquidField::Block& block) { add(block); });
  }
  SurfaceMesh mesh;

 private:
  static constexpr int n = LiquidField::vertices;
  static constexpr int stride[3] = {1, n, n* n};

  void add(const LiquidField::Block& block) {
    points_.assign(std::size_t{3} * n * n * n, -1);
    const vtkMarchingCubesTriangleCases* cases = vtkMarchingCubesTriangleCases::GetCases();
    std::array<int, 3> low{}, high{};  // cells beyond have no corner in the liquid
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(0, block.low[a] - 1);
      high[a] = std::min(LiquidField::cells - 1, block.high[a]);
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          int inside = 0;
          for (int c = 0; c < 8; ++c)
            if (block.value[at(i + corner[c][0], j + corner[c][1], k + corner[c][2])] >= level) inside |= 1 << c;
          if (inside == 0 || inside == 255) continue;
          for (const auto* edge = cases[inside].edges; *edge >= 0; edge += 3)  // VTK 9.3 has no EDGE_LIST
            mesh.triangles.push_back(
                {point(block, {i, j, k}, edge[0]), point(block, {i, j, k}, edge[1]), point(block, {i, j, k}, edge[2])});
        }
  }

  static std::size_t at(int i, int j, int k) { return static_cast<std::size_t>((k * n + j) * n + i); }

  /// The mesh's point on an edge of a cell.
  Index point(const LiquidField::Block& block, std::array<int, 3> v, int edge) {
    for (std::size_t a = 0; a < 3; ++a) v[a] += corner[edge_corner[edge]][a];
    const auto axis = static_cast<std::size_t>(edge_axis[edge]);
    const std::size_t begin = at(v[0], v[1], v[2]);
    Index& known = points_[3 * begin + axis];
    if (known >= 0) return known;
    Index* shared = nullptr;  // with other blocks
    bool on_face = false;
    for (std::size_t a = 0; a < 3; ++a) on_face = on_face || (a != axis && (v[a] == 0 || v[a] == LiquidField::cells));
    LatticeEdge name{block.first, edge_axis[edge]};
    for (std::size_t a = 0; a < 3; ++a) name.vertex[a] += v[a];
    if (on_face) {
      shared = &faces_.try_emplace(name, -1).first->second;
      if (*shared >= 0) return known = *shared;
    }
    const double from = block.value[begin], to = block.value[begin + static_cast<std::size_t>(stride[axis])];
    Vec3 x{};
    for (std::size_t a = 0; a < 3; ++a) x[a] = (static_cast<double>(name.vertex[a]) + 0.5) * step_;
    x[axis] += std::clamp((level - from) / (to - from), 0.02, 0.98) * step_;  // no triangle without area
    known = static_cast<Index>(mesh.points.size());
    mesh.points.push_back(x);
    if (shared) *shared = known;
    return known;
  }

  double step_;
  std::vector<Index> points_;  // of this block: 3 · vertex + axis
  std::unordered_map<LatticeEdge, Index, LatticeEdgeHash> faces_;
};

/// What the field says about the surface's points.
struct Surroundings {
  std::vector<double> density;  // δ of the particles around, 1
  std::vector<Index> nearest;   // particle
  std::vector<Vec3> velocity;   // m/s
};

Surroundings look_around(const LiquidField& field, const HostState& state, const std::vector<Vec3>& points,
                         int threads) {
  const std::size_t n = points.size();
  Surroundings s{std::vector<double>(n), std::vector<Index>(n, -1), std::vector<Vec3>(n)};
  for_ranges(n, threads, [&](std::size_t i) {
    double sum = 0, density = 0, most = 0;
    Vector3d velocity = Vector3d::Zero();
    field.for_near(points[i], [&](const Blob& blob, double weight) {
      sum += weight;
      density += weight * std::min(1.0, blob.density);
      velocity += weight * to_eigen(state.fluid_velocity[static_cast<std::size_t>(blob.particle)]);
      if (weight > most) most = weight, s.nearest[i] = blob.particle;
    });
    if (sum > 0) s.density[i] = density / sum, s.velocity[i] = to_vec3(velocity / sum);
  });
  return s;
}

/// Of each point, in a closed mesh: each of its neighbours once, as the next corner of the triangles in their order.
Rows next_corners(const SurfaceMesh& mesh) {
  Rows next;
  next.start.assign(mesh.points.size() + 1, 0);
  for (const auto& t : mesh.triangles)
    for (const Index p : t) ++next.start[static_cast<std::size_t>(p) + 1];
  std::partial_sum(next.start.begin(), next.start.end(), next.start.begin());
  next.item.resize(3 * mesh.triangles.size());
  std::vector<Index> free(next.start.begin(), next.start.end() - 1);
  for (const auto& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c)
      next.item[static_cast<std::size_t>(free[static_cast<std::size_t>(t[c])]++)] = t[(c + 1) % 3];
  return next;
}

/// Taubin's filter.
void smooth(SurfaceMesh& mesh, const std::vector<double>& density, int threads) {
  const Rows next = next_corners(mesh);
  std::vector<Vec3> moved(mesh.points.size());
  for (int pass = 0; pass < 20; ++pass) {
    const double factor = pass % 2 == 0 ? 0.5 : -0.53;
    for_ranges(mesh.points.size(), threads, [&](std::size_t i) {
      Vector3d sum = Vector3d::Zero();
      for (Index k = next.start[i]; k < next.start[i + 1]; ++k)
        sum += to_eigen(mesh.points[static_cast<std::size_t>(next.item[static_cast<std::size_t>(k)])]);
      const double share = std::clamp((density[i] - 0.3) / 0.3, 0.0, 1.0);  // 0.2: a lone particle
      const Vector3d x = to_eigen(mesh.points[i]);
      moved[i] = to_vec3(x + factor * share * (sum / (next.start[i + 1] - next.start[i]) - x));
    });
    mesh.points.swap(moved);
  }
}

void keep_out_of_bodies(const Model& model, const HostState& state, double gap, std::vector<Vec3>& points,
                        int threads) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const auto& q = state.body_orientation[b];
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    const Vector3d center = to_eigen(body.center), now = to_eigen(state.body_position[b]);
    for_ranges(points.size(), threads, [&](std::size_t i) {
      Vec3 normal;
      const Vector3d x = to_eigen(points[i]),
                     before = turn.conjugate() * (x - now) + center;  // as the body lies at t = 0
      const double distance = signed_distance(body, to_vec3(before), normal);
      if (distance < gap) points[i] = to_vec3(x + (gap - distance) * (turn * to_eigen(normal)));
    });
  }
}

void keep_on_side_of_cloth(const Model& model, const HostState& state, double gap, const std::vector<Index>& nearest,
                           std::vector<Vec3>& points, int threads) {
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : model.mesh.triangle) triangles->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> cloth;
  cloth->SetPoints(make_points(state.node_position));
  cloth->SetPolys(triangles);
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(cloth);
  locator->BuildLocator();
  cloth->BuildCells();
  for_parts(points.size(), threads, [&](std::size_t begin, std::size_t end) {
    vtkNew<vtkGenericCell> cell;  // a thread's own
    for (std::size_t i = begin; i < end; ++i) {
      if (nearest[i] < 0) continue;
      const Vec3& from = state.fluid_position[static_cast<std::size_t>(nearest[i])];
      double t = 0, coordinates[3];
      Vec3 hit;
      int part = 0;
      vtkIdType id = -1;
      if (locator->IntersectWithLine(from.data(), points[i].data(), 0, t, hit.data(), coordinates, part, id, cell) == 0)
        continue;
      const Vector3d way = to_eigen(hit) - to_eigen(from);
      const double length = way.norm();
      points[i] = to_vec3(to_eigen(from) + way * (length > gap ? 1 - gap / length : 0));
    }
  });
}

/// Of the triangles around each point, by their areas.
std::vector<Vec3> normals_of(const SurfaceMesh& mesh) {
  std::vector<Vector3d> sum(mesh.points.size(), Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const auto x = [&](std::size_t c) { return to_eigen(mesh.points[static_cast<std::size_t>(t[c])]); };
    const Vector3d normal = (x(1) - x(0)).cross(x(2) - x(0));
    for (const Index p : t) sum[static_cast<std::size_t>(p)] += normal;
  }
  std::vector<Vec3> normals;
  normals.reserve(sum.size());
  for (const Vector3d& v : sum) normals.push_back(to_vec3(v.normalized()));
  return normals;
}

}  // namespace

Grid surface_grid(const Model& model, const HostState& state, int threads) {
  const LiquidField field(model, state, model.scene.output.surface_spacing * model.spacing, threads);
  SurfaceMesh mesh = Contour(field).mesh;
  const Surroundings around = look_around(field, state, mesh.points, threads);
  smooth(mesh, around.density, threads);
  const double gap = 0.02 * model.spacing;
  if (model.has_cloth()) keep_on_side_of_cloth(model, state, gap, around.nearest, mesh.points, threads);
  keep_out_of_bodies(model, state, gap, mesh.points, threads);
  const std::vector<Vec3> normals = normals_of(mesh);

  auto grid = Grid::New();
  grid->SetPoints(make_points(mesh.points));
  vtkNew<vtkCellArray> cells;
  for (const auto& t : mesh.triangles) cells->InsertNextCell({t[0], t[1], t[2]});
  grid->SetCells(VTK_TRIANGLE, cells);
  vtkDataSetAttributes* fields = grid->GetPointData();
  const std::size_t n = mesh.points.size();
  add_field<vtkFloatArray>(fields, "normal", n, [&](std::size_t i) { return normals[i]; });
  fields->SetActiveNormals("normal");
  add_field<vtkFloatArray>(fields, "velocity", n, [&](std::size_t i) { return around.velocity[i]; });
  return grid;
}

}  // namespace drench
