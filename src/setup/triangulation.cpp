#include "setup/triangulation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/eigen_vec.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<int, 3>;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double clearance = 0.02;  // of an ear's longest side: what it keeps from other corners where it can

class EarClipping {
 public:
  explicit EarClipping(const std::vector<Vec3>& corners) {
    for (const Vec3& x : corners) x_.push_back(to_eigen(x));
    for (std::size_t i = 0; i < x_.size(); ++i) {
      next_.push_back(static_cast<int>((i + 1) % x_.size()));
      previous_.push_back(static_cast<int>((i + x_.size() - 1) % x_.size()));
    }
    Vector3d sum = Vector3d::Zero();
    double lengths = 0;
    for (std::size_t i = 2; i < x_.size(); ++i) {
      const Vector3d part = (x_[i - 1] - x_[0]).cross(x_[i] - x_[0]);
      sum += part;
      lengths += part.norm();
    }
    has_normal_ = sum.norm() > 1e-12 * lengths;  // none where parts of a crossed polygon cancel
    if (has_normal_) normal_ = sum.normalized();
    for (std::size_t i = 0; i < x_.size(); ++i) measure_.push_back(measure(static_cast<int>(i)));
  }

  std::vector<Triangle> cut() {
    std::vector<Triangle> triangles;
    int some = 0;  // a corner that is left
    for (std::size_t left = x_.size(); left > 3; --left) {
      const int ear = next_ear(some);
      triangles.push_back({ear, next_[at(ear)], previous_[at(ear)]});
      some = next_[at(ear)];
      remove(ear);
    }
    triangles.push_back(last(next_[at(some)]));
    return triangles;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  const Vector3d& x(int i) const { return x_[at(i)]; }
  Vector3d across(int i) const { return (x(i) - x(previous_[at(i)])).cross(x(next_[at(i)]) - x(i)); }
  double perimeter(int i) const {
    return (x(i) - x(previous_[at(i)])).norm() + (x(next_[at(i)]) - x(i)).norm() +
           (x(next_[at(i)]) - x(previous_[at(i)])).norm();
  }
  /// Perimeter²/area of a corner's ear; infinite if the polygon is concave there, or straight.
  double measure(int i) const {
    const double area = has_normal_ ? across(i).dot(normal_) : across(i).norm();
    const double around = perimeter(i);
    return area > 1e-14 * around * around ? around * around / area : infinite;
  }
  /// The same, whichever way the ear is turned.
  double shape(int i) const {
    const double area = across(i).norm(), around = perimeter(i);
    return area > 1e-14 * around * around ? around * around / area : infinite;
  }
  /// Is no other corner in the ear, or nearer to it than `margin`, m? Corners at the ear's own do not count.
  bool is_free(int ear, double margin) const {
    const int a = previous_[at(ear)], b = ear, c = next_[at(ear)];
    const auto beyond = [&](int from, int to, const Vector3d& p) {
      const Vector3d side = x(to) - x(from);
      return side.cross(p - x(from)).dot(normal_) < -margin * side.norm();
    };
    for (int p = next_[at(c)]; p != a; p = next_[at(p)]) {
      const Vector3d& q = x(p);
      if (q == x(a) || q == x(b) || q == x(c)) continue;
      // At the two sides that the ear has in common with the polygon only what lies in it blocks.
      const Vector3d ab = x(b) - x(a), bc = x(c) - x(b);
      if (ab.cross(q - x(a)).dot(normal_) < 0 || bc.cross(q - x(b)).dot(normal_) < 0 || beyond(c, a, q)) continue;
      return false;
    }
    return true;
  }
  double longest_side(int i) const {
    return std::max({(x(i) - x(previous_[at(i)])).norm(), (x(next_[at(i)]) - x(i)).norm(),
                     (x(next_[at(i)]) - x(previous_[at(i)])).norm()});
  }

  /// The least of `value` among the corners that are left and may be cut; the first of equals. −1: none.
  template <class Value, class MayBeCut>
  int least(int some, const Value& value, const MayBeCut& may_be_cut) const {
    int best = -1, i = some;
    double lowest = infinite;
    do {
      const double here = value(i);
      if ((here < lowest || (here == lowest && here < infinite && i < best)) && may_be_cut(i)) {
        best = i;
        lowest = here;
      }
      i = next_[at(i)];
    } while (i != some);
    return best;
  }
  int next_ear(int some) const {
    const auto measured = [&](int i) { return measure_[at(i)]; };
    int ear = -1;
    if (has_normal_) {
      ear = least(some, measured, [&](int i) { return is_free(i, clearance * longest_side(i)); });
      if (ear < 0) ear = least(some, measured, [&](int i) { return is_free(i, 0); });
    }
    // It crosses itself, or goes to and fro.
    const auto any = [](int) { return true; };
    if (ear < 0) ear = least(some, measured, any);
    if (ear < 0)
      ear = least(
          some, [&](int i) { return shape(i); }, any);
    return ear < 0 ? some : ear;
  }
  void remove(int ear) {
    const int before = previous_[at(ear)], after = next_[at(ear)];
    next_[at(before)] = after;
    previous_[at(after)] = before;
    measure_[at(before)] = measure(before);
    measure_[at(after)] = measure(after);
  }
  /// The last three corners, beginning with one of least measure: `opposite` to the last ear if it is one. (Which
  /// corner a triangle begins with decides roundings, and VTK's filter began so.)
  Triangle last(int opposite) const {
    int first = opposite;
    for (const int i : {previous_[at(opposite)], next_[at(opposite)]})
      if (measure_[at(i)] < measure_[at(first)]) first = i;
    return {first, next_[at(first)], previous_[at(first)]};
  }

  std::vector<Vector3d> x_;
  std::vector<int> next_, previous_;
  std::vector<double> measure_;
  Vector3d normal_ = Vector3d::Zero();
  bool has_normal_ = false;
};

}  // namespace

std::vector<std::array<int, 3>> triangulate(const std::vector<Vec3>& corners) {
  if (corners.size() < 3) return {};
  if (corners.size() == 3) return {{0, 1, 2}};
  return EarClipping(corners).cut();
}

}  // namespace drench
