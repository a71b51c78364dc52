#pragma once
// States of two runs, bit for bit.

#include <gtest/gtest.h>

#include <string_view>
#include <type_traits>

#include "state/host_state.hpp"

namespace drench::test {

inline void expect_same(const HostState& a, const HostState& b) {
  visit_fields(a, [&](std::string_view name, const auto& values) {
    visit_fields(b, [&](std::string_view same, const auto& theirs) {
      if constexpr (std::is_same_v<decltype(values), decltype(theirs)>)
        if (name == same) {
          EXPECT_TRUE(values == theirs) << name;
        }
    });
  });
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.supplied, b.supplied);
  EXPECT_EQ(a.drained, b.drained);
}

}  // namespace drench::test
