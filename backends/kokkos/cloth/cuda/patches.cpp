#include "cloth/cuda/patches.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "core/host_copy.hpp"

namespace drench::kokkos_backend {
namespace {

/// Nodes in the order of a Z-curve through their rest positions, so that those of a block lie together.
std::vector<Index> along_z_curve(const std::vector<Vec3>& rest) {
  Vec3 lo{1e300, 1e300, 1e300};
  double extent = 0;
  for (const Vec3& x : rest)
    for (int a = 0; a < 3; ++a) lo[a] = std::min(lo[a], x[a]);
  for (const Vec3& x : rest)
    for (int a = 0; a < 3; ++a) extent = std::max(extent, x[a] - lo[a]);
  std::vector<std::uint64_t> code(rest.size(), 0);
  for (std::size_t n = 0; n < rest.size(); ++n)
    for (int a = 0; a < 3; ++a) {
      const auto cell = extent > 0 ? static_cast<std::uint64_t>((rest[n][a] - lo[a]) / extent * 1048575) : 0;
      for (int bit = 0; bit < 20; ++bit) code[n] |= (cell >> bit & 1) << (3 * bit + a);
    }
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return code[static_cast<std::size_t>(a)] < code[static_cast<std::size_t>(b)];
  });
  return order;
}

}  // namespace

Patches make_patches(const Constants& constants, const Cloth& cloth, int own_nodes) {
  const auto start = on_host_now(cloth.nodes.link_start);
  const auto link = on_host_now(cloth.nodes.link);
  const std::vector<Index> order = along_z_curve(constants.model.mesh.rest_position);
  std::vector<Index> place(order.size()), around_start{0}, around;
  for (std::size_t p = 0; p < order.size(); ++p) place[static_cast<std::size_t>(order[p])] = static_cast<Index>(p);
  std::vector<std::uint16_t> local(link.extent(0));
  Patches patches;
  for (std::size_t first = 0; first < order.size(); first += static_cast<std::size_t>(own_nodes)) {
    std::map<Index, int> seen;  // node → its number among those around
    for (std::size_t p = first; p < std::min(order.size(), first + static_cast<std::size_t>(own_nodes)); ++p)
      for (Index r = start(order[p]); r < start(order[p] + 1); ++r) {
        const Index other = link(r).other, at = place[static_cast<std::size_t>(other)] - static_cast<Index>(first);
        if (at >= 0 && at < own_nodes) {
          local[static_cast<std::size_t>(r)] = static_cast<std::uint16_t>(at);
          continue;
        }
        const auto [entry, fresh] = seen.try_emplace(other, static_cast<int>(seen.size()));
        if (fresh) around.push_back(other);
        local[static_cast<std::size_t>(r)] = static_cast<std::uint16_t>(own_nodes + entry->second);
      }
    around_start.push_back(static_cast<Index>(around.size()));
    patches.most = std::max(patches.most, static_cast<int>(seen.size()));
  }
  patches.order = to_device<Index>("drench::cloth::patch_order", order);
  patches.local = to_device<std::uint16_t>("drench::cloth::patch_place", local);
  patches.around_start = to_device<Index>("drench::cloth::patch_around_start", around_start);
  patches.around = to_device<Index>("drench::cloth::patch_around", around);
  return patches;
}

}  // namespace drench::kokkos_backend
