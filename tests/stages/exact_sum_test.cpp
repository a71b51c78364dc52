// Sums that do not depend on their order: the same words whatever the order, as fine and as far as their scales say.

#include "core/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace drench::test {
namespace {

using kokkos_backend::ErrorScale;
using kokkos_backend::ExactScale;
using kokkos_backend::ExactSum;

constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

/// Terms of both signs over 40 powers of two.
std::vector<double> terms(std::size_t count, double unit) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> part(-1, 1), power(-30, 10);
  std::vector<double> all(count);
  for (double& t : all) t = unit * part(random) * std::exp2(power(random));
  return all;
}

ExactSum sum(const ExactScale& scale, const std::vector<double>& all, std::size_t from = 0, std::size_t step = 1) {
  ExactSum s;
  for (std::size_t i = from; i < all.size(); i += step) s += scale(all[i]);
  return s;
}

bool same(const ExactSum& a, const ExactSum& b) { return a.high == b.high && a.low == b.low; }

/// Bits of a word for so many terms.
int bits_for(double count) { return 62 - static_cast<int>(std::ceil(std::log2(count))); }

}  // namespace

TEST(exact_sum, any_order_and_any_parts_give_the_same_words) {
  std::vector<double> all = terms(20000, 3e-4);
  const ExactScale scale(20000, 3e-4);
  const ExactSum whole = sum(scale, all);
  for (const std::size_t parts : {2, 3, 7, 64}) {  // of ranks, or threads
    ExactSum together;
    for (std::size_t p = parts; p-- > 0;) together += sum(scale, all, p, parts);
    EXPECT_TRUE(same(together, whole)) << parts;
  }
  std::mt19937 random(1);
  double plain = 0;
  bool depends = false;
  for (int k = 0; k < 20; ++k) {
    const double before = plain;
    plain = 0;
    for (const double t : all) plain += t;
    depends = depends || (k > 0 && plain != before);
    EXPECT_TRUE(same(sum(scale, all), whole)) << k;
    std::shuffle(all.begin(), all.end(), random);
  }
  EXPECT_TRUE(depends) << "or a sum of doubles would do";
}

/// A term is cut to 2^(−3b/2) units: a sum of n terms is at most n times that off.
TEST(exact_sum, is_as_fine_as_it_says) {
  for (const double count : {2.0, 1000.0, 1e6, 3e9})
    for (const double unit : {1e-9, 1.0, 7e5}) {
      const int bits = bits_for(count);
      const double finest = unit * std::exp2(-(bits / 2) - bits);
      const ExactScale scale(count, unit);
      for (const double sign : {1.0, -1.0}) {
        const ExactSum seen = scale(sign * 1.25 * finest), unseen = scale(sign * 0.75 * finest);
        EXPECT_EQ(seen.high, 0);
        EXPECT_EQ(seen.low, static_cast<std::int64_t>(sign)) << count << " " << unit;
        EXPECT_EQ(unseen.low, 0) << count << " " << unit;
      }
      const auto n = static_cast<std::size_t>(std::min(count, 5000.0));
      const std::vector<double> all = terms(n, unit);
      long double true_sum = 0;
      double sizes = 0;
      for (const double t : all) {
        true_sum += t;
        sizes += std::abs(t);
      }
      const double rounding = 4e-16 * sizes;  // of the scaled terms and of the value, which are doubles
      EXPECT_NEAR(scale.value(sum(scale, all)), static_cast<double>(true_sum),
                  static_cast<double>(n) * finest + rounding)
          << count << " " << unit;
    }
}

TEST(exact_sum, of_a_million_terms_reaches_from_2_to_the_minus_63_to_2_to_the_21_units) {
  const ExactScale scale(1e6, 1);
  EXPECT_EQ(scale(std::exp2(-63)).low, 1);
  EXPECT_EQ(scale(std::exp2(-64)).low, 0);
  EXPECT_EQ(scale.value(scale(std::exp2(21))), std::exp2(21));
  EXPECT_EQ(scale.value(scale(std::exp2(21.5))), std::exp2(21)) << "the largest";
  EXPECT_LT(scale.value(scale(std::exp2(21) - 1)), std::exp2(21));
}

TEST(exact_sum, what_is_too_large_or_no_number_counts_as_the_largest) {
  for (const double count : {1.0, 2.0, 3.0, 1e6, 1e9}) {
    const ExactScale scale(count, 1);
    const ExactSum largest = scale(infinity);
    EXPECT_EQ(largest.high, std::int64_t{1} << bits_for(std::max(2.0, count)));
    EXPECT_EQ(largest.low, 0);
    EXPECT_TRUE(same(scale(1e300), largest));
    EXPECT_TRUE(same(scale(std::numeric_limits<double>::max()), largest));
    EXPECT_TRUE(same(scale(nan), largest)) << scale(nan).high;
    EXPECT_TRUE(same(scale(-nan), largest));
    EXPECT_EQ(scale(-infinity).high, -largest.high);
    // As many of the largest as there may be do not leave the word.
    EXPECT_LE(static_cast<double>(largest.high) * count, std::exp2(62));
    const double s = scale.value(largest);
    EXPECT_TRUE(std::isfinite(s) && s > 0);
  }
}

TEST(exact_sum, as_many_of_the_largest_as_may_be_do_not_overflow) {
  const std::int64_t count = 1 << 20;
  const ExactScale scale(static_cast<double>(count), 1);
  ExactSum all, low;
  const double below = std::nextafter(std::exp2(-21), 0);  // a low word that is nearly full
  for (std::int64_t k = 0; k < count; ++k) {
    all += scale(nan);
    low += scale(below);
  }
  EXPECT_EQ(all.high, std::int64_t{1} << 62);
  EXPECT_EQ(scale.value(all), std::exp2(41));
  EXPECT_GT(low.low, std::int64_t{1} << 61);
  EXPECT_NEAR(scale.value(low), 0.5, 1e-12);
}

TEST(exact_sum, errors_add_up_in_any_order) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> below(0, 1.4);  // to its eighth power: 15
  std::vector<double> errors(10000);
  double true_sum = 0;
  for (double& e : errors) true_sum += e = 1e-3 * std::pow(below(random), 8);
  const ErrorScale scale(10000, 1e-3);
  std::int64_t first = 0;
  for (int k = 0; k < 10; ++k) {
    std::int64_t s = 0;
    for (const double e : errors) s += scale(e);
    if (k == 0) first = s;
    EXPECT_EQ(s, first);
    std::shuffle(errors.begin(), errors.end(), random);
  }
  EXPECT_NEAR(scale.value(first), true_sum, 10000 * 1e-3 * std::exp2(4 - bits_for(10000)) + 1e-12 * true_sum);
}

TEST(exact_sum, an_error_of_a_million_is_as_fine_as_2_to_the_minus_38_units_and_16_at_most) {
  const double unit = 2e-3;
  const ErrorScale scale(1e6, unit);
  EXPECT_EQ(scale(unit * std::exp2(-38) * 1.25), 1);
  EXPECT_EQ(scale(unit * std::exp2(-38) * 0.75), 0);
  EXPECT_EQ(scale(0), 0);
  const double most = 16 * unit;
  EXPECT_NEAR(scale.value(scale(0.99 * most)), 0.99 * most, unit * std::exp2(-38));
  for (const double large : {most, 1.01 * most, 1e300, infinity, nan, -nan}) {
    EXPECT_EQ(scale(large), std::int64_t{1} << 42) << large;
    EXPECT_DOUBLE_EQ(scale.value(scale(large)), most) << large;
  }
}

}  // namespace drench::test
