#pragma once

#include <numeric>
#include <vector>

#include "base/types.hpp"

namespace drench::test {

inline Quanta sum(const std::vector<Quanta>& masses) {
  return std::accumulate(masses.begin(), masses.end(), Quanta{0});
}

}  // namespace drench::test
