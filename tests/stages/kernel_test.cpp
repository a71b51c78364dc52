// The smoothing kernels: normalisation, gradient, and the density of a lattice.

#include "core/kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace drench::test {

using kokkos_backend::Kernel;
using kokkos_backend::Real;

constexpr KernelKind every_kernel[] = {KernelKind::cubic, KernelKind::wendland, KernelKind::poly6};

TEST(kernel, integrates_to_one) {
  const double h = 0.02;
  for (const KernelKind kind : every_kernel) {
    const Kernel kernel(kind, Real(h));
    const int n = 20000;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      const double r = (k + 0.5) * h / n;
      sum += 4 * std::numbers::pi * r * r * double(kernel.value(Real(r))) * h / n;
    }
    EXPECT_NEAR(sum, 1, 1e-6) << int(kind);
  }
}

TEST(kernel, grad_factor_is_the_derivative_over_r) {
  const double h = 0.5;
  for (const KernelKind kind : {KernelKind::cubic, KernelKind::wendland}) {
    const Kernel kernel(kind, Real(h));
    for (double q : {0.05, 0.2, 0.45, 0.55, 0.7, 0.95}) {
      const double r = q * h, e = 1e-3 * h;
      const double derivative = (double(kernel.value(Real(r + e))) - double(kernel.value(Real(r - e)))) / (2 * e);
      EXPECT_NEAR(double(kernel.grad_factor(Real(r))) * r, derivative, 2e-3 * double(kernel.value(0)) / h) << int(kind);
    }
  }
}

TEST(kernel, grad_factor_of_poly6_is_the_spiky_one) {
  const double h = 0.5;
  const Kernel kernel(KernelKind::poly6, Real(h));
  const auto spiky = [h](double r) { return 15 / (std::numbers::pi * std::pow(h, 6)) * std::pow(h - r, 3); };
  for (double q : {0.01, 0.2, 0.45, 0.55, 0.7, 0.95}) {
    const double r = q * h, e = 1e-5 * h;
    const double derivative = (spiky(r + e) - spiky(r - e)) / (2 * e);
    EXPECT_NEAR(double(kernel.grad_factor(Real(r))) * r / derivative, 1, 1e-5) << q;
  }
}

TEST(kernel, grad_factor_of_pairs_is_held_at_its_steepest) {
  const double h = 0.5;
  for (const KernelKind kind : every_kernel) {
    const Kernel kernel(kind, Real(h));
    double steepest = 0, at = 0;
    for (int k = 1; k < 1000; ++k) {
      const double r = k * h / 1000, steep = -r * double(kernel.grad_factor(Real(r)));
      if (steep > steepest) at = r;
      steepest = std::max(steepest, steep);
    }
    for (int k = 1; k < 1000; ++k) {
      const double r = k * h / 1000, expected = r < at ? steepest : -r * double(kernel.grad_factor(Real(r)));
      EXPECT_NEAR(-r * double(kernel.pair(Real(r) * Real(r)).grad_factor), expected, 1e-3 * steepest)
          << int(kind) << " at " << r;
      EXPECT_NEAR(double(kernel.pair(Real(r) * Real(r)).value), double(kernel.value(Real(r))),
                  1e-5 * double(kernel.value(0)));
    }
    EXPECT_EQ(kernel.pair(0).grad_factor, 0) << int(kind);
  }
}

/// What compact pairs compute anew is what lists keep elsewhere, in metres and in steps of a lattice.
TEST(kernel, slope_of_a_pair_is_its_factor) {
  for (const KernelKind kind : every_kernel)
    for (const double h : {0.013, 16384.0}) {
      const Kernel kernel(kind, Real(h));
      const kokkos_backend::PairSlope slope(kind, Real(h));
      for (int k = 1; k < 500; ++k) {
        const Real r = Real(k * h / 500), factor = kernel.pair(r * r).grad_factor;
        EXPECT_NEAR(double(-kernel.grad_scale * slope(r * r)) / double(factor), 1, k < 490 ? 2e-5 : 1e-3)
            << int(kind) << " " << k;
      }
      EXPECT_TRUE(std::isfinite(slope(0)));
    }
}

TEST(kernel, ends_at_the_support_and_is_finite_at_zero) {
  const double h = 0.5;
  for (const KernelKind kind : every_kernel) {
    const Kernel kernel(kind, Real(h));
    EXPECT_EQ(kernel.value(Real(h)), 0);
    EXPECT_EQ(kernel.grad_factor(Real(h)), 0);
    EXPECT_EQ(kernel.value(Real(1.01 * h)), 0);
    EXPECT_EQ(kernel.grad_factor(Real(1.01 * h)), 0);
    EXPECT_TRUE(std::isfinite(double(kernel.grad_factor(0))));
    for (double q = 0.01; q < 1; q += 0.01) EXPECT_LT(kernel.grad_factor(Real(q * h)), 0);
  }
}

TEST(kernel, density_of_a_lattice) {
  const double d = 0.01;
  const double expected[] = {1.0000, 1.0338, 1.0098};  // docs/theory/liquid.md
  for (int kind = 0; kind < 3; ++kind) {
    const Kernel kernel(every_kernel[kind], Real(2 * d));
    double sum = 0;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -2; k <= 2; ++k)
          sum += d * d * d * double(kernel.value(Real(d * std::sqrt(i * i + j * j + k * k))));
    EXPECT_NEAR(sum, expected[kind], 1e-4) << kind;
  }
}

}  // namespace drench::test
