#include "scene/smoothing_kernel.hpp"

#include <cmath>
#include <numbers>

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

}  // namespace drench
