// Stage measures of the oracle; the law stands in src/stages/measures.hpp.

#include <Eigen/Core>

#include "neighbor_search.hpp"

namespace drench::reference {
namespace {

void clumping(const ReferenceState& state, StepReport& report) {
  const Vectors x = vectors(state.s.fluid_position);
  std::vector<double> distance;  // in d
  Index close = 0;
  const auto radius = [&](std::size_t i) {
    return 0.5 * state.model.spacing * std::cbrt(static_cast<double>(state.s.fluid_mass[i]) / quanta_per_particle);
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    double nearest = state.model.support;
    bool crowded = false;
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (j == i) continue;
      const double r = (x[j] - x[i]).norm();
      nearest = std::min(nearest, r);
      crowded = crowded || r < 0.5 * (radius(i) + radius(j));
    }
    if (crowded) ++close;
    if (nearest < state.model.support) distance.push_back(nearest / state.model.spacing);
  }
  if (!x.empty()) report.close_share = static_cast<double>(close) / static_cast<double>(x.size());
  if (distance.empty()) return;
  double mean = 0;
  for (const double r : distance) mean += r / static_cast<double>(distance.size());
  for (const double r : distance)
    report.nearest_variance += (r - mean) * (r - mean) / static_cast<double>(distance.size());
}

/// λ_min/λ_max of one cloth, `mass` the liquid that it holds in quanta.
double isotropy(const ReferenceState& state, const ClothMaterial& cloth, double& mass) {
  Eigen::Matrix<double, 2, 3> plane;
  for (int a = 0; a < 2; ++a) plane.row(a) = vec(cloth.rest_plane[a]);
  const auto rest_uv = [&](Index n) -> Eigen::Vector2d {
    return plane * (vec(state.model.mesh.rest_position[n]) - vec(cloth.rest_center));
  };
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double size = 0;  // ⟨u² + v²⟩
  mass = 0;
  const Index last = cloth.first_node + cloth.node_count;
  for (Index n = cloth.first_node; n < last; ++n) {
    const auto m = static_cast<double>(state.s.node_liquid[n]);
    mass += m;
    mean += m * rest_uv(n);
    size += m * rest_uv(n).squaredNorm();
  }
  if (!(mass > 0)) return 0;
  mean /= mass;
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  for (Index n = cloth.first_node; n < last; ++n) {
    const Eigen::Vector2d away = rest_uv(n) - mean;
    moment += static_cast<double>(state.s.node_liquid[n]) / mass * away * away.transpose();
  }
  const Eigen::Vector2d lambda = eigenvalues(moment);
  return lambda[1] > 1e-12 * size / mass ? std::max(0.0, lambda[0] / lambda[1]) : 0;
}

}  // namespace

void measures(ReferenceState& state, const StepInfo&, StepReport& report) {
  clumping(state, report);
  double all = 0, sum = 0;
  for (const ClothMaterial& cloth : state.model.cloths) {
    if (!cloth.porous) continue;
    double mass = 0;
    sum += isotropy(state, cloth, mass) * mass;
    all += mass;
  }
  if (all > 0) report.wet_isotropy = sum / all;
}

}  // namespace drench::reference
