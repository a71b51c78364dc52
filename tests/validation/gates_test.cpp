// The gates themselves: a row that got worse fails, and so does a bound that no longer bites.

#include <gtest/gtest.h>

#include <cmath>

#include "validation.hpp"

namespace drench::test {
namespace {

/// A row with a target of 1.
Finding row(double measured, const Reached& reached = {}, const std::string& reason = "why") {
  return {"case", "theory", measured, 1, "1", reached, reason};
}

/// The objections of a host's run in float, joined.
std::string of_host(const Finding& f) {
  std::string all;
  for (const std::string& one : objections(f, false, true)) all += one + "\n";
  return all;
}

bool passes_on_a_gpu(const Finding& f) { return objections(f, false, false).empty(); }

}  // namespace

TEST(gates, a_met_row_asserts_its_target) {
  EXPECT_EQ(of_host(row(1)), "");
  EXPECT_EQ(of_host(row(-1, {}, "")), "");
  EXPECT_NE(of_host(row(1.001)), "");
  EXPECT_NE(of_host(row(0.9, {1.2, 0})), "") << "the bound of a row that is met";
  EXPECT_NE(of_host(row(1.3, {0, 1.4})), "") << "the bound is that of the other precision";
  EXPECT_EQ(of_host(row(0.9, {0, 1.4})), "");
}

TEST(gates, a_missed_row_asserts_a_bound_that_bites) {
  EXPECT_EQ(of_host(row(2, {2.2, 0})), "");
  EXPECT_NE(of_host(row(2.21, {2.2, 0})), "");
  EXPECT_NE(of_host(row(1.99, {2.2, 0})), "") << "10.6 % of slack";
  EXPECT_NE(of_host(row(2, {2.2, 0}, "")), "") << "no reason";
  EXPECT_NE(of_host(row(2)), "") << "a reason without a bound";
}

TEST(gates, scatter_lets_a_better_run_pass_and_holds_the_bound) {
  EXPECT_EQ(of_host(row(0.5, {2.2, 0, 2})), "") << "met here, missed elsewhere";
  EXPECT_NE(of_host(row(0.5, {2.3, 0, 2})), "") << "15 % above the worst that is known";
  EXPECT_NE(of_host(row(0.5, {1.05, 0, 0.99})), "") << "met everywhere";
  EXPECT_NE(of_host(row(0.5, {0, 0, 2})), "") << "a scatter without a bound";
  EXPECT_EQ(of_host(row(2.19, {2.2, 0, 2})), "");
}

TEST(gates, a_gpu_holds_the_bounds_and_may_do_better) {
  EXPECT_TRUE(passes_on_a_gpu(row(1.5, {2.2, 0})));
  EXPECT_TRUE(passes_on_a_gpu(row(0.5, {2.2, 0})));
  EXPECT_FALSE(passes_on_a_gpu(row(2.3, {2.2, 0})));
  EXPECT_FALSE(passes_on_a_gpu(row(1.001)));
}

TEST(gates, nothing_that_is_no_number_passes) {
  for (const double measured : {double(NAN), double(INFINITY)}) {
    EXPECT_NE(of_host(row(measured)), "");
    EXPECT_NE(of_host(row(measured, {2.2, 2.2, 2})), "");
    EXPECT_FALSE(passes_on_a_gpu(row(measured, {2.2, 0})));
  }
}

}  // namespace drench::test
