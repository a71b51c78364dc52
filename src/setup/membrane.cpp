#include "setup/membrane.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "base/eigen_vec.hpp"
#include "setup/cloth_mesh.hpp"

namespace drench {
namespace {

double limit_weight(const MaterialScene& fabric) {
  if (!(fabric.strain_limit > 0)) return 0;
  return straight_yarns * (fabric.membrane ? std::max(fabric.membrane->warp, fabric.membrane->weft) : fabric.stretch);
}

}  // namespace

std::vector<std::array<double, 2>> warp_in_triangles(const ClothMesh& mesh, const SurfaceMesh& own) {
  const std::size_t first = mesh.triangle.size() - own.triangles.size();
  std::vector<std::array<double, 2>> in_triangle;
  for (std::size_t t = 0; t < own.triangles.size(); ++t) {
    const auto at = [&](std::size_t c) { return to_eigen(own.points[static_cast<std::size_t>(own.triangles[t][c])]); };
    const Eigen::Vector3d warp = to_eigen(mesh.triangle_warp[first + t]), along = (at(1) - at(0)).normalized(),
                          rest = at(2) - at(0);
    const Eigen::Vector2d own_axes(along.dot(warp), (rest - along * along.dot(rest)).normalized().dot(warp));
    in_triangle.push_back({own_axes.x() / own_axes.norm(), own_axes.y() / own_axes.norm()});
  }
  return in_triangle;
}

void set_triangle_stiffness(Model& model, const std::vector<std::vector<std::array<double, 2>>>& warp) {
  ClothMesh& mesh = model.mesh;
  const std::vector<ClothScene>& cloths = model.scene.cloths;
  const bool limits = model.any_cloth([](const ClothMaterial& c) { return c.strain_limit > 0; });
  const bool membranes = std::any_of(cloths.begin(), cloths.end(), [](const ClothScene& c) {
    return any_fabric(c, [](const MaterialScene& f) { return f.membrane.has_value(); });
  });
  if (!limits && !membranes) return;
  std::vector<std::array<Index, 2>> entries;
  for (Index t = 0; t < mesh.triangles(); ++t) {
    const auto& corner = mesh.triangle[static_cast<std::size_t>(t)];
    const auto at = [&](std::size_t c) { return to_eigen(mesh.rest_position[static_cast<std::size_t>(corner[c])]); };
    Eigen::Matrix<double, 3, 2> edges;
    edges << at(1) - at(0), at(2) - at(0);
    const Eigen::Matrix2d r = (edges.transpose() * edges).llt().matrixU();
    const Eigen::Matrix2d inverse = r.inverse();
    mesh.triangle_shape.push_back({inverse(0, 0), inverse(0, 1), inverse(1, 1)});
    const auto cloth = static_cast<std::size_t>(mesh.triangle_cloth[static_cast<std::size_t>(t)]);
    const MaterialScene& fabric = model.fabric_of_triangle(t);
    const double weight = limit_weight(fabric), area = 0.5 * r(0, 0) * r(1, 1);
    if (limits) mesh.limit_stiffness.push_back(weight * 0.5 * r(0, 0) * r(1, 1));
    if (membranes) mesh.membrane.emplace_back();
    if (fabric.membrane) {
      const auto& [c, s] = warp[cloth][static_cast<std::size_t>(t - model.cloths[cloth].first_triangle)];
      const MembraneScene& m = *fabric.membrane;
      mesh.membrane.back() = {
          c, s, m.warp * area, m.weft * area, m.shear * area, m.wet, m.warp_locking, m.weft_locking};
    }
    if (weight <= 0 && !fabric.membrane) continue;
    for (Index c = 0; c < 3; ++c) entries.push_back({corner[static_cast<std::size_t>(c)], 4 * t + c});
  }
  mesh.node_triangles = rows_of(mesh.nodes(), entries);
}

}  // namespace drench
