#include "setup/mesh_guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/eigen_vec.hpp"
#include "setup/file_place.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

constexpr double largest_in_metres = 5, largest_in_centimetres = 300;  // a curtain; a garment of 3 m
constexpr double largest_in_decimetres = 30;                           // a body of 3 m
constexpr double garment_in_decimetres = 20;                           // 2 m; 20 cm would be a handkerchief
constexpr double flat = 0.1, taller = 1.2;                             // of the longest side; of the other side
constexpr double rare_unit = 0.6;                                      // misfit up to which inches are believed
constexpr double centred = 0.2, grounded = 0.3;  // the middle's distance from the origin over the side's length

Vector3d sides_of(const Box& box) { return to_eigen(box.max) - to_eigen(box.min); }
Vector3d middle_of(const Box& box) { return 0.5 * (to_eigen(box.max) + to_eigen(box.min)); }

void guess_unit(const Box& box, MeshGuess& guess) {
  const double size = sides_of(box).maxCoeff();
  if (size > largest_in_centimetres)
    guess.unit = LengthUnit::mm;
  else if (size > garment_in_decimetres)
    guess.unit = LengthUnit::cm;
  else if (size > largest_in_metres)
    guess.unit = LengthUnit::dm;
  if (guess.unit != LengthUnit::m) guess.unit_reason = fmt::format("it is {:.4g} units long", size);
}

void guess_up(const Box& box, MeshGuess& guess) {
  const Vector3d side = sides_of(box), middle = middle_of(box);
  const double size = side.maxCoeff();
  if (side[2] < flat * size && side[1] >= flat * size) return;  // it stands
  if (side[1] < flat * size) return;                            // it lies
  if (side[0] > 2 * std::max(side[1], side[2]) && middle[0] > grounded * side[0]) {
    guess.up = UpAxis::x;
    guess.up_reason = fmt::format("x is its longest side and runs from {:.3g} to {:.3g}", box.min[0], box.max[0]);
    return;
  }
  const auto off = [&](int axis) { return middle[axis] / side[axis]; };
  const bool z_rises =
      off(2) > grounded && std::abs(off(1))<centred, y_rises = off(1)> grounded && std::abs(off(2)) < centred;
  if (z_rises && side[2] > side[1] / taller) {
    guess.up = UpAxis::z;
    guess.up_reason =
        fmt::format("its z runs from {:.3g} to {:.3g}, and its y is centred on 0", box.min[2], box.max[2]);
  } else if (!y_rises && side[2] > taller * side[1] &&
             !(std::abs(side[0] - side[2]) < 0.1 * side[0] &&
               side[1] > 0.35 * side[0])) {  // a wide skirt is round about y
    guess.up = UpAxis::z;
    guess.up_reason = fmt::format("its z side of {:.3g} is longer than its y side of {:.3g}", side[2], side[1]);
  }
}

/// How badly a garment's box fits a body's, 1: 0 where it lies within the body's height and around its middle.
double misfit(const Box& garment, const Box& body, bool sheet) {
  const Vector3d side = sides_of(body);
  const double size = side.maxCoeff();
  const Vector3d apart = (middle_of(garment) - middle_of(body)).cwiseQuotient(side.cwiseMax(0.2 * size));
  double sum = apart.cwiseAbs().cwiseMin(1.0).sum();
  const double ratio = sides_of(garment).maxCoeff() / size;
  if (!sheet) sum += std::max(0.0, std::log(ratio / 1.3)) * 3;  // sheets are often larger than what they cover
  sum += std::max(0.0, std::log(0.15 / ratio)) * 3;
  const double depth = std::max(sides_of(garment)[2], 0.01 * sides_of(garment).maxCoeff()) / side[2];
  sum += std::max(0.0, std::log(0.6 / depth));  // it goes around the body
  const double beyond = (to_eigen(body.min) - to_eigen(garment.min)).cwiseMax(0.0).sum() +
                        (to_eigen(garment.max) - to_eigen(body.max)).cwiseMax(0.0).sum();
  return sum + std::min(1.0, beyond / size);  // the ratio above counts what is larger still
}

/// How much too small a cloth is, whatever it lies on: 0 from 15 cm on.
double dwarfish(const Box& file_box, const MeshGuess& guess) {
  return 1.5 * std::max(0.0, std::log(0.15 / sides_of(upright_box(file_box, guess)).maxCoeff()));
}

}  // namespace

Box bounds_of(const std::vector<Vec3>& points) {
  Box box{points.front(), points.front()};
  for (const Vec3& x : points)
    for (std::size_t a = 0; a < 3; ++a) {
      box.min[a] = std::min(box.min[a], x[a]);
      box.max[a] = std::max(box.max[a], x[a]);
    }
  return box;
}

Box upright_box(const Box& file_box, const MeshGuess& guess) {
  const Eigen::Matrix3d linear = metres_in(guess.unit) * upright(guess.up);
  return bounds_of({to_vec3(linear * to_eigen(file_box.min)), to_vec3(linear * to_eigen(file_box.max))});
}

MeshGuess guess_of(const Box& file_box) {
  MeshGuess guess;
  guess_unit(file_box, guess);
  guess_up(file_box, guess);
  return guess;
}

void check_guess(const Box& file_box, const MeshGuess& guess, const std::string& label) {
  constexpr double least = 0.002, most = 100;  // m
  const double units = sides_of(file_box).maxCoeff(), size = units * metres_in(guess.unit);
  if (size >= least && size <= most) return;
  if (!(units > 0 && std::isfinite(units))) return;  // other checks have a better text
  throw SetupError(fmt::format(
      "{} is {:.3g} units long, which is no usual size in m, dm, cm, mm or inch; convert the file to one of these "
      "units, or write mesh: {{file: …, scale: {:g}}} into the scene of drench new without a mesh",
      label, units, std::pow(1000, -std::round(std::log10(units) / 3))));
}

MeshGuess guess_of_body(const Box& file_box) {
  MeshGuess guess = guess_of(file_box);
  const double size = sides_of(file_box).maxCoeff();
  if (size > largest_in_metres && size <= largest_in_decimetres) {
    guess.unit = LengthUnit::dm;
    guess.unit_reason = fmt::format("it is {:.3g} units long, a person in decimetres", size);
  }
  return guess;
}

MeshGuess guess_beside(const Box& file_box, const Box& body_file_box, const MeshGuess& body) {
  const Box around = upright_box(body_file_box, body);
  const MeshGuess alike{body.unit, body.up, body.unit == LengthUnit::m ? "" : "as the body",
                        body.up == UpAxis::y ? "" : "as the body"};
  const bool sheet = sides_of(file_box).minCoeff() < 0.01 * sides_of(file_box).maxCoeff();
  const std::string fits = "then it fits the body";
  MeshGuess best = alike;
  double least = misfit(upright_box(file_box, best), around, sheet) + dwarfish(file_box, best) -
                 0.2;  // files of one pair are likely alike
  for (const LengthUnit unit : {LengthUnit::m, LengthUnit::dm, LengthUnit::cm, LengthUnit::mm, LengthUnit::inch})
    for (const UpAxis up : {UpAxis::y, UpAxis::z, UpAxis::x}) {
      const MeshGuess guess{unit, up, unit == body.unit ? alike.unit_reason : fits,
                            up == body.up ? alike.up_reason : fits};
      const bool inch = unit == LengthUnit::inch, decimetres = unit == LengthUnit::dm && unit != body.unit;
      if (sheet && (decimetres || up != body.up)) continue;  // it fits around nothing
      const double off = misfit(upright_box(file_box, guess), around, sheet) + dwarfish(file_box, guess) +
                         (up == UpAxis::x ? 0.1 : 0) + (inch || decimetres ? 0.1 : 0);
      if (off >= least || (inch && off > rare_unit)) continue;
      least = off;
      best = guess;
    }
  constexpr double poor = 1.5;  // misfit
  for (std::string* reason : {&best.unit_reason, &best.up_reason})
    if (least > poor && *reason == fits) *reason = "which fits the body best, but not well";
  return best;
}

}  // namespace drench
