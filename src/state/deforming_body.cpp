#include "state/deforming_body.hpp"

#include <algorithm>
#include <cmath>

namespace drench {

FilePart files_at(const Deformation& shape, double time) {
  const std::size_t last = shape.points.size() - 1;
  const double at = std::clamp(time * shape.fps, 0.0, static_cast<double>(last));
  const auto first = std::min(static_cast<std::size_t>(at), last);
  return {first, std::min(first + 1, last), at - static_cast<double>(first)};
}

double rate_after(const Deformation& shape, double time) {
  return time >= 0 && files_at(shape, time).first + 1 < shape.points.size() ? shape.fps : 0;
}

namespace {

Vec3 between(const Vec3& a, const Vec3& b, double part) {
  return {a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * (b[2] - a[2])};
}

}  // namespace

std::vector<Vec3> points_at(const Deformation& shape, double time) {
  const FilePart at = files_at(shape, time);
  std::vector<Vec3> points = shape.points[at.first];
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = between(points[i], shape.points[at.last][i], at.part);
  return points;
}

Vec3 lattice_origin(const Body& body, double time) {
  const FilePart at = files_at(body.shape, time);
  Vec3 origin = between(body.shape.center[at.first], body.shape.center[at.last], at.part);
  for (std::size_t a = 0; a < 3; ++a) origin[a] -= 0.5 * (body.field.points[a] - 1) * body.field.spacing;
  return origin;
}

double fastest_point(const Deformation& shape, double from, double to) {
  double fastest = 0;
  for (std::size_t k = files_at(shape, from).first; k <= files_at(shape, to).first && k < shape.speed.size(); ++k)
    fastest = std::max(fastest, shape.speed[k]);
  return fastest;
}

double fastest_point(const Deformation& shape) {
  return shape.speed.empty() ? 0 : *std::max_element(shape.speed.begin(), shape.speed.end());
}

}  // namespace drench
