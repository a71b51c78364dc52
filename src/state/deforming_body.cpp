#include "state/deforming_body.hpp"

#include <algorithm>
#include <cmath>

namespace drench {

double rate_after(const Deformation& shape, double time) {
  const FilePart at = files_at(shape.time, time);
  return at.first == at.last ? 0 : 1 / (shape.time[at.last] - shape.time[at.first]);
}

namespace {

Vec3 between(const Vec3& a, const Vec3& b, double part) {
  return {a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * (b[2] - a[2])};
}

}  // namespace

std::vector<Vec3> points_at(const Deformation& shape, double time) {
  const FilePart at = files_at(shape.time, time);
  std::vector<Vec3> points = shape.points[at.first];
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = between(points[i], shape.points[at.last][i], at.part);
  return points;
}

Vec3 lattice_origin(const Body& body, double time) {
  const FilePart at = files_at(body.shape.time, time);
  Vec3 origin = between(body.shape.center[at.first], body.shape.center[at.last], at.part);
  for (std::size_t a = 0; a < 3; ++a) origin[a] -= 0.5 * (body.field.points[a] - 1) * body.field.spacing;
  return origin;
}

double fastest_point(const Deformation& shape, double from, double to) {
  double fastest = 0;
  const std::size_t last = files_at(shape.time, to).first;
  for (std::size_t k = files_at(shape.time, from).first; k <= last && k < shape.speed.size(); ++k)
    fastest = std::max(fastest, shape.speed[k]);
  return fastest;
}

double fastest_point(const Deformation& shape) {
  return shape.speed.empty() ? 0 : *std::max_element(shape.speed.begin(), shape.speed.end());
}

}  // namespace drench
