#include <fmt/format.h>

#include <cstring>
#include <functional>

#include "parallel/communicator.hpp"

namespace drench {

void require_agreement(const Communicator& ranks, const std::vector<std::pair<std::string, std::string>>& texts) {
  std::vector<std::size_t> own;
  for (const auto& [name, text] : texts) own.push_back(std::hash<std::string>()(text));
  const std::vector<std::byte> bytes = ranks.all_gather(own.data(), own.size() * sizeof(std::size_t));
  std::vector<std::size_t> all(bytes.size() / sizeof(std::size_t));
  std::memcpy(all.data(), bytes.data(), bytes.size());
  for (std::size_t r = 1; r * own.size() < all.size(); ++r)
    for (std::size_t k = 0; k < own.size(); ++k)
      if (all[r * own.size() + k] != all[k])
        throw RanksError(fmt::format("rank {} has another {} than rank 0; all ranks of a run must have the same", r,
                                     texts[k].first));
}

}  // namespace drench
