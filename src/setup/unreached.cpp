#include "setup/unreached.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Shape = DrainScene::Shape;
using Kind = ProbeScene::Kind;

Eigen::AlignedBox3d box_of(const Box& box) { return {to_eigen(box.min), to_eigen(box.max)}; }

bool is_outside(const DrainScene& drain, const Eigen::AlignedBox3d& domain) {
  if (drain.shape == Shape::box) return !domain.intersects(box_of(drain.box));
  if (drain.shape == Shape::sphere) return domain.exteriorDistance(to_eigen(drain.center)) > drain.radius;
  double lowest = std::numeric_limits<double>::infinity();  // of the domain's corners, along the normal
  for (int c = 0; c < 8; ++c)
    lowest = std::min(
        lowest, to_eigen(drain.normal).dot(domain.corner(Eigen::AlignedBox3d::CornerType(c)) - to_eigen(drain.point)));
  return lowest >= 0;
}

/// m; infinite for a plane
double thickness_of(const DrainScene& drain) {
  if (drain.shape == Shape::box) return box_of(drain.box).sizes().minCoeff();
  return drain.shape == Shape::sphere ? 2 * drain.radius : std::numeric_limits<double>::infinity();
}

bool is_outside(const ProbeScene& probe, const Eigen::AlignedBox3d& domain) {
  const Eigen::Vector3d x = to_eigen(probe.position);
  if (probe.kind == Kind::line) {
    Eigen::AlignedBox3d line(x);
    return !domain.intersects(line.extend(to_eigen(probe.end)));
  }
  return domain.exteriorDistance(x) > probe.radius;
}

}  // namespace

void warn_of_unreached(const Model& m, std::vector<std::string>& lines) {
  const Eigen::AlignedBox3d domain = box_of(m.scene.domain);
  const std::vector<DrainScene>& drains = m.scene.fluid.drains;
  for (std::size_t k = 0; k < drains.size(); ++k) {
    if (is_outside(drains[k], domain))
      lines.push_back(fmt::format("fluid.drains.{}: it is outside the domain, where there is no liquid; move it", k));
    else if (const double thickness = thickness_of(drains[k]); thickness < m.spacing)
      lines.push_back(fmt::format(
          "fluid.drains.{}: it is {:.3g} m thick, less than a particle, {:.3g} m, which can pass through it "
          "within a step; make it {:.2g} m thick",
          k, thickness, m.spacing, 2 * m.spacing));
  }
  for (const ProbeScene& probe : m.scene.output.probes)
    if (probe.kind != Kind::body && probe.kind != Kind::cloth && is_outside(probe, domain))
      lines.push_back(
          fmt::format("probe '{}': it is outside the domain, where there is no liquid; move it", probe.name));
}

}  // namespace drench
