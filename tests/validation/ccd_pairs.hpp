#pragma once
// Random and degenerate pairs of a particle and a triangle, and a referee in long double that says whether they meet.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace drench::test::ccd {

using Eigen::Vector3d;
using Real80 = long double;
using Vector80 = Eigen::Matrix<Real80, 3, 1>;

inline constexpr double edge = 0.02;           // m: size of the triangles
inline constexpr double usual = 0.002;         // m: a usual path, 1 m/s in a step of 2 ms
inline constexpr double touch = 1e-6 * 0.01;   // m: as in stage advection with d = 10 mm
inline constexpr double inside_margin = 1e-5;  // barycentric: what the referee calls clear
inline constexpr double tolerance = 1e-6;      // of the longest edge: what the law accepts beyond the edges

/// The ways of a triangle and of a particle in one step, m.
struct Pair {
  std::array<Vector3d, 3> from, to;
  Vector3d x0, x1;
};

/// Decides in long double whether a particle and a triangle meet.
struct Referee {
  std::array<Vector80, 3> from, to;
  Vector80 x0, x1;
  std::array<Real80, 4> bernstein;  // of the coplanarity f(τ), m³
  Real80 noise;                     // m³: |f| below this is rounding of the double computation

  explicit Referee(const Pair& p) {
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] = p.from[k].cast<Real80>();
      to[k] = p.to[k].cast<Real80>();
    }
    x0 = p.x0.cast<Real80>();
    x1 = p.x1.cast<Real80>();
    const Vector80 a = x0 - from[0], u = from[1] - from[0], v = from[2] - from[0];
    const Vector80 b = x1 - to[0], r = to[1] - to[0], s = to[2] - to[0];
    // The trilinear form at (τ, τ, τ): its polar values are Bernstein's coefficients.
    const auto det = [](const Vector80& i, const Vector80& j, const Vector80& k) { return i.dot(j.cross(k)); };
    bernstein = {det(a, u, v), (det(b, u, v) + det(a, r, v) + det(a, u, s)) / 3,
                 (det(a, r, s) + det(b, u, s) + det(b, r, v)) / 3, det(b, r, s)};
    const Real80 point = std::max(a.norm(), b.norm()), side = std::max(u.norm(), r.norm()),
                 other = std::max(v.norm(), s.norm());
    noise = 64 * 2.3e-16L * point * side * other;
  }

  std::array<Vector80, 3> triangle(Real80 t) const {
    std::array<Vector80, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = from[k] + t * (to[k] - from[k]);
    return c;
  }
  Vector80 point(Real80 t) const { return x0 + t * (x1 - x0); }
  Real80 value(Real80 t) const {
    const auto c = triangle(t);
    return (point(t) - c[0]).dot((c[1] - c[0]).cross(c[2] - c[0]));
  }
  /// The least barycentric coordinate of the foot point; −1e9 for a triangle without area.
  Real80 least_weight(Real80 t) const {
    const auto c = triangle(t);
    const Vector80 u = c[1] - c[0], v = c[2] - c[0], p = point(t) - c[0], n = u.cross(v);
    const Real80 area = n.squaredNorm();
    if (!(area > 1e-13L * u.squaredNorm() * v.squaredNorm())) return -1e9L;
    const Real80 w1 = p.cross(v).dot(n) / area, w2 = u.cross(p).dot(n) / area;
    return std::min(std::min(w1, w2), 1 - w1 - w2);
  }

  /// Appends the parts of [lo, hi] of length 2^-40 in which f may vanish, ascending.
  static void isolate(const std::array<Real80, 4>& b, Real80 lo, Real80 hi, int depth,
                      std::vector<std::array<Real80, 2>>& out) {
    const Real80 least = std::min(std::min(b[0], b[1]), std::min(b[2], b[3]));
    const Real80 most = std::max(std::max(b[0], b[1]), std::max(b[2], b[3]));
    if (least > 0 || most < 0) return;
    if (depth == 40 || (least == 0 && most == 0)) {
      if (!out.empty() && out.back()[1] >= lo)
        out.back()[1] = hi;
      else
        out.push_back({lo, hi});
      return;
    }
    const Real80 ab = (b[0] + b[1]) / 2, bc = (b[1] + b[2]) / 2, cd = (b[2] + b[3]) / 2, abc = (ab + bc) / 2,
                 bcd = (bc + cd) / 2, middle = (abc + bcd) / 2, half = (lo + hi) / 2;
    isolate({b[0], ab, abc, middle}, lo, half, depth + 1, out);
    isolate({middle, bcd, cd, b[3]}, half, hi, depth + 1, out);
  }

  /// The first clear crossing: f changes its sign by more than the noise within the triangle's margin. 2: none.
  Real80 clear_crossing() const {
    std::vector<std::array<Real80, 2>> roots;
    isolate(bernstein, 0, 1, 0, roots);
    for (std::size_t k = 0; k < roots.size(); ++k) {
      const Real80 before = k == 0 ? 0 : (roots[k - 1][1] + roots[k][0]) / 2;
      const Real80 after = k + 1 == roots.size() ? 1 : (roots[k][1] + roots[k + 1][0]) / 2;
      const Real80 f0 = value(before), f1 = value(after);
      if (!(std::abs(f0) > noise && std::abs(f1) > noise) || (f0 > 0) == (f1 > 0)) continue;
      if (least_weight(roots[k][0]) > inside_margin && least_weight(roots[k][1]) > inside_margin)
        return (roots[k][0] + roots[k][1]) / 2;
    }
    return 2;
  }

  /// Ends on the triangle: within half of what the backend calls touching.
  bool clear_touch_at_end() const {
    const auto c = triangle(1);
    const Vector80 n = (c[1] - c[0]).cross(c[2] - c[0]);
    return std::abs(value(1)) <= 0.5L * touch * n.norm() && least_weight(1) > inside_margin;
  }

  /// How far a reported hit is from the triangle at that time, beyond what the law allows; m.
  Real80 beyond(Real80 t) const {
    const auto c = triangle(t);
    Real80 nearest = 1e9L, size = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector80& a = c[k];
      const Vector80 e = c[(k + 1) % 3] - a;
      const Real80 s =
          std::clamp((point(t) - a).dot(e) / std::max(e.squaredNorm(), Real80(1e-300L)), Real80(0), Real80(1));
      nearest = std::min(nearest, (point(t) - a - s * e).norm());
      size = std::max(size, e.norm());
    }
    if (least_weight(t) >= 0) {
      const Vector80 n = (c[1] - c[0]).cross(c[2] - c[0]);
      nearest = std::min(nearest, std::abs(value(t)) / n.norm());
    }
    return nearest - (tolerance * size + touch);
  }
};

/// Random pairs, one kind after the other; the same ones each time.
class Pairs {
 public:
  static constexpr int kinds = 10;

  Pair make(int kind) {
    switch (kind) {
      case 4:
        return coplanar();
      case 5:
        return still();
      case 6:
        return sliver();
      case 7:
        return collapsing();
      case 8:
        return at_an_end();
      case 9:
        return grazing();
      default:
        return aimed(random_triangle(edge), kind < 3);
    }
  }

 private:
  std::mt19937_64 random_{20020701};
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  double power(double lo, double hi) { return std::pow(10, uniform(lo, hi)); }
  Vector3d direction() {
    std::normal_distribution<double> n;
    return Vector3d(n(random_), n(random_), n(random_)).normalized();
  }
  Vector3d place() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  /// 1 to 100 times the usual path.
  Vector3d path() { return usual * power(0, 2) * direction(); }
  Vector3d weights() {
    const double a = std::sqrt(uniform(0, 1)), b = uniform(0, 1);
    return {1 - a, a * (1 - b), a * b};
  }
  static Vector3d at(const std::array<Vector3d, 3>& t, const Vector3d& w) {
    return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
  }

  Pair random_triangle(double size) {
    Pair p;
    const Vector3d center = place(), common = path();
    for (std::size_t k = 0; k < 3; ++k) {
      p.from[k] = center + size * direction();
      p.to[k] = p.from[k] + common + (uniform(0, 1) < 0.5 ? 0.2 : 1.0) * path();
    }
    return p;
  }
  /// A path that meets the triangle's plane within the triangle at a random time, or (`aim` false) any path near it.
  Pair aimed(Pair p, bool aim = true) {
    const double t = uniform(0, 1);
    std::array<Vector3d, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = p.from[k] + t * (p.to[k] - p.from[k]);
    const Vector3d d = path();
    p.x0 = at(c, weights()) - t * d;
    if (!aim) p.x0 += uniform(0, 1) * edge * direction();
    p.x1 = p.x0 + d;
    return p;
  }
  /// All in the plane z = 0, exactly.
  Pair coplanar() {
    Pair p = aimed(random_triangle(edge), uniform(0, 1) < 0.5);
    for (Vector3d* v : {&p.from[0], &p.from[1], &p.from[2], &p.to[0], &p.to[1], &p.to[2], &p.x0, &p.x1}) (*v)[2] = 0.25;
    return p;
  }
  /// The particle, the triangle or both do not move.
  Pair still() {
    Pair p = random_triangle(edge);
    const int which = static_cast<int>(uniform(0, 3));
    if (which != 0) p.to = p.from;
    p = aimed(p);
    if (which != 1) p.x1 = p.x0;
    return p;
  }
  Pair sliver() {
    Pair p = random_triangle(edge);
    const double height = edge * power(-6, -2);
    const Vector3d common = path(), aside = direction();
    p.from[2] = p.from[0] + uniform(0.2, 0.8) * (p.from[1] - p.from[0]) + height * aside;
    for (std::size_t k = 0; k < 3; ++k) p.to[k] = p.from[k] + common;
    if (uniform(0, 1) < 0.5) p.to[1] += 0.1 * path();
    return aimed(p);
  }
  /// A corner passes through the opposite edge within the step, or ends on it: the area vanishes there.
  Pair collapsing() {
    Pair p = random_triangle(edge);
    const double w = uniform(-0.2, 1.2), past = uniform(0, 1) < 0.3 ? 0 : uniform(0, 2);
    const Vector3d goal = p.to[0] + w * (p.to[1] - p.to[0]);
    const Vector3d start = p.from[0] + w * (p.from[1] - p.from[0]);
    p.to[2] = goal - past * (p.from[2] - start);
    return aimed(p);
  }
  Pair at_an_end() {
    Pair p = aimed(random_triangle(edge));
    (uniform(0, 1) < 0.5 ? p.x0 : p.x1) = Vector3d::Zero();
    if (p.x0 == Vector3d::Zero())
      p.x0 = at(p.from, weights());
    else
      p.x1 = at(p.to, weights());
    return p;
  }
  /// f has two roots close together, one double root or just none: the path is shifted along the normal.
  Pair grazing() {
    Pair p = aimed(random_triangle(edge));
    const Referee r(p);
    Real80 best = 0, at_best = -1;
    for (int k = 1; k < 200; ++k) {
      const Real80 t = k / 200.0L, slope0 = r.value(t) - r.value(t - 0.005L), slope1 = r.value(t + 0.005L) - r.value(t);
      if ((slope0 > 0) != (slope1 > 0) && r.least_weight(t) > best) {
        best = r.least_weight(t);
        at_best = t;
      }
    }
    if (at_best < 0) return p;
    Real80 lo = at_best - 0.005L, hi = at_best + 0.005L;
    const bool top = r.value(at_best) > r.value(lo);
    for (int k = 0; k < 100; ++k) {
      const Real80 a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
      ((r.value(a) < r.value(b)) == top ? lo : hi) = ((r.value(a) < r.value(b)) == top ? a : b);
    }
    const auto c = r.triangle(lo);
    const Vector80 n = (c[1] - c[0]).cross(c[2] - c[0]);
    const double depth = uniform(0, 1) < 0.2 ? 0 : (uniform(0, 1) < 0.5 ? 1 : -1) * edge * power(-12, -3);
    const Vector3d shift = (-r.value(lo) / n.squaredNorm() * n + Real80(depth) * n / n.norm()).cast<double>();
    p.x0 += shift;
    p.x1 += shift;
    return p;
  }
};

}  // namespace drench::test::ccd
