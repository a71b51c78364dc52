#pragma once
// Sums of floating numbers that are the same in any order, and so on any number of threads and of ranks: each term
// becomes an integer, and integers add up exactly. Law: docs/dev/distribution.md, Sums in fixed steps.

#include <cmath>
#include <cstdint>

#include "core/types.hpp"

namespace drench::kokkos_backend {

/// A sum in two words, of which the second goes on where the first one's resolution ends.
struct ExactSum {
  std::int64_t high = 0, low = 0;
  KOKKOS_INLINE_FUNCTION ExactSum& operator+=(const ExactSum& o) {
    high += o.high;
    low += o.low;
    return *this;
  }
};

/// For sums of at most `terms` terms with a natural size of `unit`. With b = 62 − log2(terms) bits a word, terms reach
/// from 2^(−3b/2) to 2^(b/2) units: 2^−63 to 2^21 of a million. What is larger, or no number, counts as the largest.
class ExactScale {
 public:
  ExactScale() = default;
  ExactScale(double terms, double unit) {
    const int bits = 62 - static_cast<int>(std::ceil(std::log2(terms > 2 ? terms : 2)));
    to_steps_ = std::ldexp(1.0, bits / 2) / unit;
    fine_ = most_ = std::ldexp(1.0, bits);
  }
  KOKKOS_INLINE_FUNCTION ExactSum operator()(double term) const {
    double x = to_steps_ * term;
    x = x < most_ ? x : most_;
    x = x > -most_ ? x : -most_;
    const auto high = static_cast<std::int64_t>(x);
    return {high, static_cast<std::int64_t>((x - static_cast<double>(high)) * fine_)};
  }
  double value(const ExactSum& s) const {
    return (static_cast<double>(s.high) + static_cast<double>(s.low) / fine_) / to_steps_;
  }

 private:
  double to_steps_ = 0, fine_ = 1, most_ = 0;
};

/// For sums of at most `terms` errors: numbers of 0 and more that are seldom above one `unit`. One word serves: 2^−38
/// units at the finest for a million terms. What is above 16 units, or no number, counts as 16.
class ErrorScale {
 public:
  ErrorScale() = default;
  ErrorScale(double terms, double unit) {
    const int bits = 62 - static_cast<int>(std::ceil(std::log2(terms > 2 ? terms : 2)));
    to_steps_ = std::ldexp(1.0, bits - 4) / unit;
    most_ = std::ldexp(1.0, bits);
  }
  KOKKOS_INLINE_FUNCTION std::int64_t operator()(double term) const {
    const double x = to_steps_ * term;
    return static_cast<std::int64_t>(x < most_ ? x : most_);
  }
  double value(std::int64_t sum) const { return static_cast<double>(sum) / to_steps_; }

 private:
  double to_steps_ = 0, most_ = 0;
};

}  // namespace drench::kokkos_backend
