// Stage fabric of the oracle; the law stands in src/stages/fabric.hpp. What is wet of a triangle is clipped from it.

#include <cmath>

#include "common.hpp"
#include "state/saturation.hpp"

namespace drench::reference {
namespace {

/// A corner of a polygon: along warp and weft, m, and its saturation less the least that is wet.
using Corner = Eigen::Vector3d;

/// The part of a convex polygon whose third coordinate is not negative.
std::vector<Corner> clipped(const std::vector<Corner>& polygon) {
  std::vector<Corner> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    if (a[2] >= 0) kept.push_back(a);
    if ((a[2] >= 0) != (b[2] >= 0)) kept.push_back(a + a[2] / (a[2] - b[2]) * (b - a));
  }
  return kept;
}

double area_of(const std::vector<Corner>& polygon) {
  double twice = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * std::abs(twice);
}

/// The wet part's area and extent. The plane of a cloth that is curved at rest shows its triangles smaller than they
/// are.
void measure_patch(const ReferenceState& state, const ClothMaterial& cloth, FabricNumbers& numbers) {
  const ClothMesh& mesh = state.model.mesh;
  const std::vector<double> saturation = node_saturation(state.model, state.s);
  const double least = state.model.scene.output.wet_above;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  for (Index t = cloth.first_triangle; t < cloth.first_triangle + cloth.triangle_count; ++t) {
    std::vector<Corner> triangle;
    std::vector<Eigen::Vector3d> rest;
    for (const Index n : mesh.triangle[t]) {
      rest.push_back(vec(mesh.rest_position[n]));
      const Eigen::Vector3d x = rest.back() - vec(cloth.rest_center);
      triangle.emplace_back(x.dot(vec(cloth.rest_plane[0])), x.dot(vec(cloth.rest_plane[1])), saturation[n] - least);
    }
    const std::vector<Corner> wet = clipped(triangle);
    for (const Corner& c : wet) {
      low = low.cwiseMin(c.head<2>());
      high = high.cwiseMax(c.head<2>());
    }
    const double flat = area_of(triangle), area = 0.5 * (rest[1] - rest[0]).cross(rest[2] - rest[0]).norm();
    if (flat > 1e-9 * area) {
      numbers.wet_area += area * area_of(wet) / flat;
      continue;
    }
    std::vector<Corner> unit{{0, 0, triangle[0][2]}, {1, 0, triangle[1][2]}, {0, 1, triangle[2][2]}};  // seen edge-on
    numbers.wet_area += area * 2 * area_of(clipped(unit));
  }
  if (high[0] < low[0]) return;
  numbers.wet_warp = high[0] - low[0];
  numbers.wet_weft = high[1] - low[1];
}

Quanta sum(const std::vector<Quanta>& values, Index first, Index count) {
  Quanta all = 0;
  for (Index k = first; k < first + count && !values.empty(); ++k) all += values[k];
  return all;
}

}  // namespace

void fabric(ReferenceState& state, const StepInfo&, StepReport& report) {
  report.fabrics.clear();
  for (std::size_t k = 0; k < state.model.cloths.size(); ++k) {
    const ClothMaterial& cloth = state.model.cloths[k];
    if (!cloth.porous) continue;
    FabricNumbers numbers;
    numbers.cloth = static_cast<Index>(k);
    numbers.liquid = sum(state.s.node_liquid, cloth.first_node, cloth.node_count);
    measure_patch(state, cloth, numbers);
    numbers.taken_front = sum(state.s.sample_taken_front, cloth.first_sample, cloth.sample_count);
    numbers.taken_back = sum(state.s.sample_taken_back, cloth.first_sample, cloth.sample_count);
    numbers.given_front = sum(state.s.sample_given_front, cloth.first_sample, cloth.sample_count);
    numbers.given_back = sum(state.s.sample_given_back, cloth.first_sample, cloth.sample_count);
    report.fabrics.push_back(numbers);
  }
}

}  // namespace drench::reference
