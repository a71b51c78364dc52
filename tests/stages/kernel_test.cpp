// The smoothing kernel: normalisation, gradient, and the density of a lattice.

#include "laws/kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace drench::test {

using kokkos_backend::CubicKernel;
using kokkos_backend::Real;

TEST(kernel, integrates_to_one) {
  const double h = 0.02;
  const CubicKernel kernel{Real(h)};
  const int n = 20000;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double r = (k + 0.5) * h / n;
    sum += 4 * std::numbers::pi * r * r * double(kernel.value(Real(r))) * h / n;
  }
  EXPECT_NEAR(sum, 1, 1e-6);
}

TEST(kernel, slope_is_the_derivative_over_r) {
  const double h = 0.5;
  const CubicKernel kernel{Real(h)};
  for (double q : {0.05, 0.2, 0.45, 0.55, 0.7, 0.95}) {
    const double r = q * h, e = 1e-3 * h;
    const double derivative = (double(kernel.value(Real(r + e))) - double(kernel.value(Real(r - e)))) / (2 * e);
    EXPECT_NEAR(double(kernel.slope(Real(r))) * r, derivative, 2e-3 * double(kernel.value(0)) / h);
  }
  EXPECT_EQ(kernel.value(Real(h)), 0);
  EXPECT_EQ(kernel.slope(Real(1.01 * h)), 0);
  EXPECT_TRUE(std::isfinite(double(kernel.slope(0))));
}

TEST(kernel, lattice_has_density_one) {
  const double d = 0.01;
  const CubicKernel kernel{Real(2 * d)};
  double sum = 0;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k) sum += d * d * d * double(kernel.value(Real(d * std::sqrt(i * i + j * j + k * k))));
  EXPECT_NEAR(sum, 1.000, 0.002);
}

}  // namespace drench::test
