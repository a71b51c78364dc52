// Integer arithmetic of mass transfers.

#include "porous/transfer.hpp"

#include <gtest/gtest.h>

#include <random>

namespace drench::test {

using kokkos_backend::floor_ratio;

TEST(transfer, ratios_are_exact) {
  __extension__ typedef unsigned __int128 Wide;
  std::mt19937_64 random(7);
  const auto below = [&](int bits) { return static_cast<Quanta>(random() >> (64 - bits)); };
  long near_whole = 0;
  for (int k = 0; k < 2'000'000; ++k) {
    const int bits = 1 + static_cast<int>(random() % 62);
    Quanta a = below(1 + static_cast<int>(random() % 62)), b = below(bits), c = 1 + below(bits);
    if (b > c) std::swap(b, c);
    // Quotients at and beside whole numbers: a b = n c or nearly so.
    if (k % 2 == 0) {
      if (c > Quanta{1} << 40) continue;
      const Quanta whole = 1 + below(20);
      b = 1 + below(20);
      a = whole * c / b + static_cast<Quanta>(random() % 3) - 1;
      if (a < 0) continue;
      ++near_whole;
    }
    const Wide exact = static_cast<Wide>(a) * static_cast<Wide>(b) / static_cast<Wide>(c);
    if (exact >> 63 != 0) continue;
    ASSERT_EQ(floor_ratio(a, b, c), static_cast<Quanta>(exact)) << a << " · " << b << " / " << c;
  }
  EXPECT_GT(near_whole, 100'000);
}

}  // namespace drench::test
