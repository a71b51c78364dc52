#include "setup/cloth_boundary.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/eigen_vec.hpp"
#include "setup/point_grid.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

std::vector<std::array<Index, 3>> single_edges(const ClothMesh& mesh) {
  struct Sides {
    std::array<Index, 3> first;  // with its direction in the triangle
    int count = 0;
  };
  std::map<std::array<Index, 2>, Sides> edges;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      Sides& sides = edges[{std::min(a, b), std::max(a, b)}];
      if (sides.count++ == 0) sides.first = {a, b, t[(k + 2) % 3]};
    }
  std::vector<std::array<Index, 3>> single;
  for (const auto& [nodes, sides] : edges)
    if (sides.count == 1) single.push_back(sides.first);
  return single;
}

}  // namespace

void find_boundary_edges(Model& model) {
  const ClothMesh& mesh = model.mesh;
  SampleSet& samples = model.samples;
  const double reach = 2 * model.spacing;
  model.mesh.boundary_edge = single_edges(mesh);
  if (model.mesh.boundary_edge.empty()) return;
  PointGrid grid(reach);
  for (const Vec3& x : samples.rest_position) grid.add(x);
  const auto count = static_cast<std::size_t>(samples.count());
  samples.boundary_edges.assign(count, {-1, -1});
  std::vector<double> nearest(count);
  std::vector<Vector3d> direction(count, Vector3d::Zero());  // of the nearest one
  // First the nearest edge of each sample, then the nearest that goes another way: past a corner.
  for (std::size_t which = 0; which < 2; ++which) {
    std::fill(nearest.begin(), nearest.end(), reach);
    for (std::size_t e = 0; e < mesh.boundary_edge.size(); ++e) {
      const Index node = mesh.boundary_edge[e][0];
      const Vec3& from = mesh.rest_position[static_cast<std::size_t>(node)];
      const Vec3& to = mesh.rest_position[static_cast<std::size_t>(mesh.boundary_edge[e][1])];
      const Vector3d a = to_eigen(from), along = to_eigen(to) - a;
      Vec3 low, high;
      for (std::size_t c = 0; c < 3; ++c) {
        low[c] = std::min(from[c], to[c]) - reach;
        high[c] = std::max(from[c], to[c]) + reach;
      }
      grid.for_box(low, high, [&](Index p) {
        const auto at = static_cast<std::size_t>(p);
        if (samples.cloth[at] != mesh.node_cloth[static_cast<std::size_t>(node)]) return;
        if (which == 1 && !(std::fabs(along.normalized().dot(direction[at])) < 0.9)) return;
        const Vector3d x = to_eigen(samples.rest_position[at]) - a;
        const double distance = (x - std::clamp(x.dot(along) / along.squaredNorm(), 0.0, 1.0) * along).norm();
        if (!(distance < nearest[at])) return;
        nearest[at] = distance;
        samples.boundary_edges[at][which] = static_cast<Index>(e);
        if (which == 0) direction[at] = along.normalized();
      });
    }
  }
}

}  // namespace drench
