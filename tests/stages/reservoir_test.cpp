// Stage reservoir: backend against reference from identical input.

#include <gtest/gtest.h>

#include "stage_compare.hpp"

namespace drench::test {

TEST(reservoir, agrees_with_the_reference) { compare_stage({.stage = Stage::reservoir, .changes = "node_liquid"}); }

TEST(reservoir, takes_what_is_buffered_too) {
  compare_stage({.stage = Stage::reservoir,
                 .prepare =
                     [](const Model& m, HostState& s) {
                       for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
                         s.node_buffered[n] = s.node_liquid[n] =
                             static_cast<Quanta>(3 * m.samples.node_capacity[n] / m.quantum);
                     },
                 .changes = "node_buffered"});
}

}  // namespace drench::test
