#include "view/camera.hpp"

#include <vtkCamera.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double half_angle = 15;  // degrees
constexpr double margin = 0.9;     // share of the picture that is filled

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Right, above, and toward the camera.
std::array<Vector3d, 3> axes_of(const View& view, const Vector3d& up) {
  const Vector3d other = std::abs(up.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitY();
  const Vector3d side = up.cross(other).normalized(), front = side.cross(up);
  const double azimuth = radians(view.azimuth), elevation = radians(view.elevation);
  const Vector3d toward =
      std::cos(elevation) * (std::sin(azimuth) * side + std::cos(azimuth) * front) + std::sin(elevation) * up;
  const Vector3d right = up.cross(toward).normalized();
  return {right, toward.cross(right), toward};
}

void set(vtkCamera* camera, const Vector3d& position, const Vector3d& focus, const Vector3d& up) {
  camera->SetPosition(position.data());
  camera->SetFocalPoint(focus.data());
  camera->SetViewUp(up.data());
}

}  // namespace

void place_camera(vtkRenderer* renderer, const View& view, const Vec3& up, const std::vector<Vec3>& points,
                  double aspect) {
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetViewAngle(2 * half_angle);
  if (view.fixed) {
    const auto& f = *view.fixed;
    set(camera, {f[0], f[1], f[2]}, {f[3], f[4], f[5]}, to_eigen(up));
    return;
  }
  const auto [right, above, toward] = axes_of(view, to_eigen(up));
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& axis : {right, above, toward}) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& p : points) {
      low = std::min(low, to_eigen(p).dot(axis));
      high = std::max(high, to_eigen(p).dot(axis));
    }
    if (low <= high) centre += (low + high) / 2 * axis;
  }
  const double tangent = std::tan(radians(half_angle)) * margin;
  double distance = 1e-3;
  for (const Vec3& point : points) {
    const Vector3d p = to_eigen(point) - centre;
    const double reach = std::max(std::abs(p.dot(above)), std::abs(p.dot(right)) / aspect);
    distance = std::max(distance, p.dot(toward) + reach / tangent);
  }
  set(camera, centre + distance * toward, centre, above);
}

}  // namespace drench
