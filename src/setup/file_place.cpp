#include "setup/file_place.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>

#include "base/eigen_vec.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

// m: garments and bodies that people model are between these
constexpr double largest_usual = 20, smallest_usual = 0.02, most_centimetres = 5;  // the last of files in cm

FilePlace file_place(double scale, LengthUnit unit, UpAxis up, const Vec3& axis, double degrees,
                     const Eigen::Vector3d& shift) {
  const double factor = unit == LengthUnit::m ? scale : scale * metres_in(unit);
  return {rotation_about(axis, degrees) * (factor * upright(up)), shift};
}

}  // namespace

double metres_in(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::m:
      return 1;
    case LengthUnit::dm:
      return 0.1;
    case LengthUnit::cm:
      return 0.01;
    case LengthUnit::mm:
      return 0.001;
    case LengthUnit::inch:
      return 0.0254;
  }
  return 1;
}

const char* name_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::m:
      return "m";
    case LengthUnit::dm:
      return "dm";
    case LengthUnit::cm:
      return "cm";
    case LengthUnit::mm:
      return "mm";
    case LengthUnit::inch:
      return "inch";
  }
  return "m";
}

const char* name_of(UpAxis up) { return up == UpAxis::x ? "x" : up == UpAxis::y ? "y" : "z"; }

Eigen::Matrix3d upright(UpAxis up) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (up == UpAxis::x) turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  if (up == UpAxis::z) turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return turn;
}

Eigen::Matrix3d rotation_about(const Vec3& axis, double degrees) {
  if (degrees == 0) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d along = to_eigen(axis);
  if (!(along.norm() > 0)) throw SetupError("the axis of rotation must not be zero");
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, along.normalized()).toRotationMatrix();
}

void FilePlace::operator()(std::vector<Vec3>& points) const {
  for (Vec3& x : points) x = to_vec3(linear * to_eigen(x) + shift);
}

FilePlace file_place(const ClothScene& cloth) {
  if (cloth.grid) return {rotation_about(cloth.rotate_axis, cloth.rotate_degrees), to_eigen(cloth.position)};
  return file_place(cloth.scale, cloth.unit, cloth.up, cloth.rotate_axis, cloth.rotate_degrees,
                    to_eigen(cloth.position));
}

FilePlace file_place(const PlacedFile& placed) {
  return file_place(placed.scale, placed.unit, placed.up, placed.rotate_axis, placed.rotate_degrees,
                    to_eigen(placed.position));
}

FilePlace file_place(const BodyScene& body) {
  FilePlace place = file_place(body.scale, body.unit, body.up, body.rotate_axis, 0, to_eigen(body.position));
  place.linear =
      rotation_about(body.rotate_axis, body.rotate_degrees) * to_eigen(body.stretch).asDiagonal() * place.linear;
  place.shift += to_eigen(body.place);
  return place;
}

std::string unit_hint(const std::vector<Vec3>& points, LengthUnit unit, double scale, const std::string& name) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& x : points) bounds.extend(to_eigen(x));
  int axis = 0;
  const double size = bounds.isEmpty() ? 0 : bounds.sizes().maxCoeff(&axis);
  if (!(size > 0) || !std::isfinite(size) || (size >= smallest_usual && size <= largest_usual)) return "";
  const char* sense = axis == 1 ? "tall" : "long";
  if (size < smallest_usual) {
    const std::string advice = unit != LengthUnit::m
                                   ? fmt::format("if the file is in metres, remove unit: {}", name_of(unit))
                               : scale < 1 ? fmt::format("if the file is in metres, remove scale: {}", scale)
                                           : "if that is too small, set unit or scale";
    return fmt::format("{} is {:.3g} m {}: {}", name, size, sense, advice);
  }
  const double in_centimetres = size / metres_in(unit) * metres_in(LengthUnit::cm),
               in_millimetres = size / metres_in(unit) * metres_in(LengthUnit::mm);
  const bool centimetres = unit == LengthUnit::m && in_centimetres <= most_centimetres,
             millimetres =
                 unit != LengthUnit::mm && in_millimetres >= smallest_usual && in_millimetres <= largest_usual;
  const auto advice = [&](const char* name_of_unit, const char* key, double then) {
    return fmt::format("if the file is in {}, {} unit: {} ({:.3g} m)", name_of_unit,
                       unit == LengthUnit::m ? "add" : "set", key, then);
  };
  std::string hint = fmt::format("{} is {:.3g} m {}: ", name, size, sense);
  if (centimetres) hint += advice("centimetres", "cm", in_centimetres) + (millimetres ? "; " : "");
  if (millimetres) hint += advice("millimetres", "mm", in_millimetres);
  return centimetres || millimetres ? hint : hint + "check its unit and scale";
}

}  // namespace drench
