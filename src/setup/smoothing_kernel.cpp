#include "setup/smoothing_kernel.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace drench {

double kernel_value(KernelKind kernel, double r, double h) {
  const double q = r / h, p = 1 - q, volume = std::numbers::pi * h * h * h;
  if (q >= 1) return 0;
  switch (kernel) {
    case KernelKind::wendland:
      return 21 / (2 * volume) * std::pow(p, 4) * (4 * q + 1);
    case KernelKind::poly6:
      return 315 / (64 * volume) * std::pow(1 - q * q, 3);
    case KernelKind::cubic:
      break;
  }
  return 8 / volume * (q <= 0.5 ? 6 * (q * q * q - q * q) + 1 : 2 * p * p * p);
}

double lattice_density(KernelKind kernel, double support) {
  const int reach = static_cast<int>(support) + 1;
  double sum = 0;
  for (int a = -reach; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b)
      for (int c = -reach; c <= reach; ++c) sum += kernel_value(kernel, std::sqrt(a * a + b * b + c * c), support);
  return sum;
}

double kernel_derivative(KernelKind kernel, double r, double h) {
  const double q = r / h, p = 1 - q, volume = std::numbers::pi * h * h * h;
  if (q >= 1) return 0;
  switch (kernel) {
    case KernelKind::wendland:
      return -210 / (volume * h * h) * p * p * p;
    case KernelKind::poly6:
      return -45 / (volume * h * r) * p * p;
    case KernelKind::cubic:
      break;
  }
  return 48 / (volume * h * h) * (q <= 0.5 ? 3 * q - 2 : -p * p / q);
}

double jacobi_relaxation(KernelKind kernel, double support) {
  const int reach = static_cast<int>(support) + 1;
  std::vector<Eigen::Vector3d> x, gradient;
  double squares = 0;
  for (int a = -reach; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b)
      for (int c = -reach; c <= reach; ++c) {
        const Eigen::Vector3d at(a, b, c);
        if (at.norm() == 0 || at.norm() >= support) continue;
        x.push_back(at);
        gradient.push_back(kernel_derivative(kernel, at.norm(), support) * at);
        squares += gradient.back().squaredNorm();
      }
  constexpr int waves = 16;  // on an axis, up to the lattice's shortest; the lattice's symmetry leaves a ≥ b ≥ c
  double largest = 0;
  for (int a = 1; a <= waves; ++a)
    for (int b = 0; b <= a; ++b)
      for (int c = 0; c <= b; ++c) {
        const Eigen::Vector3d k = std::numbers::pi / waves * Eigen::Vector3d(a, b, c);
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (std::size_t j = 0; j < x.size(); ++j) sum += std::sin(k.dot(x[j])) * gradient[j];
        largest = std::max(largest, sum.squaredNorm() / squares);
      }
  return std::min(0.5, 0.9 / largest);
}

}  // namespace drench
