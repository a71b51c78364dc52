#include "scene/memory_estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "scene/setup_error.hpp"

namespace drench {

double estimated_bytes(const SetupSize& size) {
  return 1000 * size.fluid + 200 * size.boundary + 700 * size.nodes + 800 * size.samples + 16 * size.field;
}

double machine_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

void refuse_too_large(const SetupSize& size, double available) {
  const std::string counts = fmt::format(
      "{:.0f} liquid particles, {:.0f} samples of bodies, {:.0f} cloth nodes and {:.0f} "
      "samples of cloth{}",
      size.fluid, size.boundary, size.nodes, size.samples,
      size.field > 0 ? fmt::format(", {:.0f} points of distance fields", size.field) : "");
  constexpr double most = 1 << 28;
  if (!(size.fluid <= most && size.boundary <= most && size.nodes <= most / 4 && size.samples <= most &&
        size.field <= 8 * most)) {
    throw SetupError(
        fmt::format("the scene is too large: {}; allowed: {:.0f} of each, {:.0f} nodes", counts, most, most / 4));
  }
  if (const double bytes = estimated_bytes(size); bytes > available) {
    throw SetupError(
        fmt::format("the scene does not fit in memory: {} need about {:.1f} GiB, the machine has {:.1f} GiB", counts,
                    bytes / (1 << 30), available / (1 << 30)));
  }
}

}  // namespace drench
