#include "core/z_curve.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace drench::kokkos_backend {

std::vector<Index> along_z_curve(const std::vector<Vec3>& point, const std::vector<Index>& part, double cell) {
  Vec3 lo{1e300, 1e300, 1e300};
  for (const Vec3& x : point)
    for (std::size_t a = 0; a < 3; ++a) lo[a] = std::min(lo[a], x[a]);
  std::vector<std::pair<Index, std::uint64_t>> code(point.size());
  for (std::size_t i = 0; i < code.size(); ++i) {
    code[i] = {part[i], 0};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto at = static_cast<std::uint64_t>(std::min((point[i][a] - lo[a]) / cell, 2097151.0));
      for (std::size_t bit = 0; bit < 21; ++bit) code[i].second |= (at >> bit & 1) << (3 * bit + a);
    }
  }
  std::vector<Index> order(code.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return code[static_cast<std::size_t>(a)] < code[static_cast<std::size_t>(b)];
  });
  return order;
}

}  // namespace drench::kokkos_backend
