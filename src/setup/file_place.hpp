#pragma once
// From the coordinates of a mesh file to those of the scene.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace drench {

/// m
double metres_in(LengthUnit unit);
const char* name_of(LengthUnit unit);
const char* name_of(UpAxis up);

/// Turns the axis that points up to y.
Eigen::Matrix3d upright(UpAxis up);

/// x = linear · (a file's point) + shift, m.
struct FilePlace {
  Eigen::Matrix3d linear;
  Eigen::Vector3d shift;

  void operator()(std::vector<Vec3>& points) const;
};

/// Of a cloth's mesh file, and of a grid, which has unit m and y up.
FilePlace file_place(const ClothScene& cloth);
FilePlace file_place(const BodyScene& body);
FilePlace file_place(const PlacedFile& placed);
/// What `place` does besides: SetupError if the axis is zero.
Eigen::Matrix3d rotation_about(const Vec3& axis, double degrees);

/// A line for a mesh whose size suggests another unit, "" for any other: "is 172 m tall: if the file is in centimetres,
/// add unit: cm (1.72 m); …", with each unit that gives a usual size. `points` are placed; `name` begins it.
std::string unit_hint(const std::vector<Vec3>& points, LengthUnit unit, double scale, const std::string& name);

}  // namespace drench
