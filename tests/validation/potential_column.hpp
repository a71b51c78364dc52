#pragma once
// A column of liquid without viscosity that collapses beside a wall and over a dry floor, in a plane: potential flow by
// boundary elements and marked points of the surface (Longuet-Higgins & Cokelet 1976). It shares nothing with the
// solver's methods.

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace drench::test {

/// Lengths are in widths a of the column, times T = t √(2 g/a).
class PotentialColumn {
 public:
  /// `height`: over the width; `finest`: length of the shortest elements.
  PotentialColumn(double height, double finest) : height_(height), finest_(finest) {
    constexpr double radius = 0.08;  // of the upper edge, which is rounded off
    constexpr int points = 3000;
    const double top = 1 - radius, arc = radius * std::numbers::pi / 2, front = height - radius;
    Eigen::ArrayXd x(points + 1), y(points + 1);
    for (int i = 0; i <= points; ++i) {
      const double way = (top + arc + front) * i / points, angle = (way - top) / radius;
      if (way <= top) {
        x[i] = way, y[i] = height;
      } else if (way <= top + arc) {
        x[i] = top + radius * std::sin(angle), y[i] = front + radius * std::cos(angle);
      } else {
        x[i] = 1, y[i] = top + arc + front - way;
      }
    }
    surface_ = {x, y, Eigen::ArrayXd::Zero(points + 1)};
    redistribute();
    begin_ = area();
  }

  /// Where the front stands at T, which never falls from call to call.
  double front(double T) {
    while (time_ < T) step(T - time_);
    return surface_.x.maxCoeff();
  }

  /// Area over that of the start, − 1: an error of the method.
  double growth() const { return area() / begin_ - 1; }

 private:
  static constexpr double g = 0.5;  // in these units

  /// Points of the surface from the wall to the floor, and the potential there.
  struct Surface {
    Eigen::ArrayXd x, y, potential;
  };

  double area() const {
    const Eigen::Index n = surface_.x.size() - 1;
    return (0.5 * (surface_.y.tail(n) + surface_.y.head(n)) * (surface_.x.tail(n) - surface_.x.head(n))).sum();
  }

  /// ∂/∂T of points and potential: velocities, and Bernoulli's equation at a surface without pressure.
  Surface rates(const Surface& s) const {
    const Eigen::Index n = s.x.size() - 1;
    const auto rise = [&](const Eigen::ArrayXd& a) -> Eigen::ArrayXd { return a.tail(n) - a.head(n); };
    const auto middle = [&](const Eigen::ArrayXd& a) -> Eigen::ArrayXd { return 0.5 * (a.tail(n) + a.head(n)); };
    const Eigen::ArrayXd dx = rise(s.x), dy = rise(s.y), length = (dx.square() + dy.square()).sqrt();
    const Eigen::ArrayXd tx = dx / length, ty = dy / length, mx = middle(s.x), my = middle(s.y);
    // φ/2 = ∮ (φ ∂G/∂n − G ∂φ/∂n), G = ln r/2π, over the surface and its mirror images in the wall and in the floor.
    Eigen::MatrixXd single = Eigen::MatrixXd::Zero(n, n), twofold = Eigen::MatrixXd::Zero(n, n);
    for (const auto& [sx, sy] : {std::array{1., 1.}, std::array{-1., 1.}, std::array{1., -1.}, std::array{-1., -1.}}) {
      const double turn = sx * sy;  // mirrored once, an element runs from its end to its beginning
      for (Eigen::Index j = 0; j < n; ++j) {
        const Eigen::Index from = turn < 0 ? j + 1 : j;
        const double ux = turn * sx * tx[j], uy = turn * sy * ty[j];
        for (Eigen::Index i = 0; i < n; ++i) {
          const double rx = sx * s.x[from] - mx[i], ry = sy * s.y[from] - my[i];
          const double along = rx * ux + ry * uy, end = along + length[j];
          const bool own = i == j && sx > 0 && sy > 0;
          const double across = own ? 0 : ry * ux - rx * uy;
          const auto part = [&](double q) { return q * (0.5 * std::log(q * q + across * across) - 1); };
          const double angle = std::abs(across) < 1e-13 ? 0 : std::atan(end / across) - std::atan(along / across);
          single(i, j) += part(end) - part(along) + across * angle;
          twofold(i, j) += angle;
        }
      }
    }
    const Eigen::VectorXd phi = middle(s.potential).matrix();
    const Eigen::ArrayXd out = single.partialPivLu().solve(twofold * phi - std::numbers::pi * phi).array();
    const Eigen::ArrayXd along = rise(s.potential) / length, mu = along * tx - out * ty, mv = along * ty + out * tx;
    Surface r{Eigen::ArrayXd::Zero(n + 1), Eigen::ArrayXd::Zero(n + 1), {}};
    for (Eigen::Index i = 1; i < n; ++i) {
      const double w = length[i] / (length[i] + length[i - 1]);
      r.x[i] = w * mu[i - 1] + (1 - w) * mu[i];
      r.y[i] = w * mv[i - 1] + (1 - w) * mv[i];
    }
    r.y[0] = (9 * mv[0] - mv[1]) / 8;  // even at the mirror
    r.x[n] = (9 * mu[n - 1] - mu[n - 2]) / 8;
    r.potential = 0.5 * (r.x.square() + r.y.square()) - g * (s.y - height_);
    return r;
  }

  void step(double time_left) {
    const Surface first = rates(surface_);
    const double speed = (first.x.square() + first.y.square()).maxCoeff(), longest = time_ < 0.02 ? 0.001 : 0.01;
    const double dt = std::min({time_left, longest, 0.4 * finest_ / (std::sqrt(speed) + 1e-9)});
    const auto moved = [&](const Surface& by, double t) {
      Surface s{surface_.x + t * by.x, surface_.y + t * by.y, surface_.potential + t * by.potential};
      s.x[0] = 0;
      s.y[s.y.size() - 1] = 0;
      return s;
    };
    surface_ = moved(rates(moved(first, 0.5 * dt)), dt);
    time_ += dt;
    redistribute();
    if (++steps_ % 10 == 0) smooth();
  }

  /// Points as dense as the tongue is thin, by cubic interpolation along the surface, which both mirrors continue.
  void redistribute() {
    const Eigen::Index n = surface_.x.size() - 1;
    const auto continued = [&](const Eigen::ArrayXd& a, Eigen::Index i, double odd_wall, double odd_floor) {
      return i < 0 ? odd_wall * a[-i] : i > n ? odd_floor * a[2 * n - i] : a[i];
    };
    Eigen::ArrayXd way(n + 5);  // of points −2 to n + 2
    way[0] = 0;
    for (Eigen::Index i = -1; i <= n + 2; ++i)
      way[i + 2] = way[i + 1] + std::hypot(continued(surface_.x, i, -1, 1) - continued(surface_.x, i - 1, -1, 1),
                                           continued(surface_.y, i, 1, -1) - continued(surface_.y, i - 1, 1, -1));
    const auto at = [&](const Eigen::ArrayXd& a, double odd_wall, double odd_floor, Eigen::Index left, double s) {
      double sum = 0;
      for (Eigen::Index i = left - 1; i <= left + 2; ++i) {
        double weight = 1;
        for (Eigen::Index k = left - 1; k <= left + 2; ++k)
          if (k != i) weight *= (s - way[k + 2]) / (way[i + 2] - way[k + 2]);
        sum += weight * continued(a, i, odd_wall, odd_floor);
      }
      return sum;
    };
    constexpr int fine = 4000;
    const double begin = way[2], end = way[n + 2];
    const auto size = [&](double y) { return std::clamp(0.3 * y, finest_, 4 * finest_); };
    Eigen::ArrayXd count(fine + 1);
    count[0] = 0;
    Eigen::Index left = 0;
    for (int k = 1; k <= fine; ++k) {
      const double s = begin + (end - begin) * (k - 0.5) / fine;
      while (left < n - 1 && way[left + 3] < s) ++left;
      count[k] = count[k - 1] + (end - begin) / fine / size(at(surface_.y, 1, -1, left, s));
    }
    const auto points = std::max<Eigen::Index>(40, std::lround(count[fine]));
    Surface next{Eigen::ArrayXd(points + 1), Eigen::ArrayXd(points + 1), Eigen::ArrayXd(points + 1)};
    left = 0;
    int k = 0;
    for (Eigen::Index i = 0; i <= points; ++i) {
      const double wanted = count[fine] * static_cast<double>(i) / static_cast<double>(points);
      while (k < fine - 1 && count[k + 1] < wanted) ++k;
      const double s = begin + (end - begin) * (k + (wanted - count[k]) / (count[k + 1] - count[k])) / fine;
      while (left < n - 1 && way[left + 3] < s) ++left;
      next.x[i] = at(surface_.x, -1, 1, left, s);
      next.y[i] = at(surface_.y, 1, -1, left, s);
      next.potential[i] = at(surface_.potential, 1, 1, left, s);
    }
    next.x[0] = 0;
    next.y[points] = 0;
    surface_ = next;
  }

  /// Takes zigzags away: the filter of Longuet-Higgins & Cokelet.
  void smooth() {
    for (Eigen::ArrayXd* a : {&surface_.x, &surface_.y, &surface_.potential}) {
      const Eigen::ArrayXd old = *a;
      const Eigen::Index n = old.size() - 4;
      a->segment(2, n) = (-old.segment(0, n) + 4 * old.segment(1, n) + 10 * old.segment(2, n) + 4 * old.segment(3, n) -
                          old.segment(4, n)) /
                         16;
    }
  }

  double height_, finest_;
  Surface surface_;
  double begin_ = 0, time_ = 0;
  int steps_ = 0;
};

}  // namespace drench::test
