#include "scene/memory_estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "scene/setup_error.hpp"

namespace drench {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Width of a list whose rows have `neighbors` in full surroundings: splashes crowd, and lists grow by a quarter and 5.
double width(double neighbors) { return 1.25 * 1.3 * neighbors + 5; }

/// Of a cell table: item, bucket, cell and a copy of each point; two indices a cell, with about two cells a point or as
/// many as a small table may have.
double table_bytes(double points, double real_bytes) {
  constexpr double index = 4, least_cells = 65536;
  return points * (5 * index + 3 * real_bytes) + 1.25 * 2 * index * std::max(least_cells, 2 * points);
}

/// Reads one number from a file of the kernel's; 0 without one.
double number_in(const char* path) {
  std::ifstream in(path);
  double value = 0;
  return in >> value ? value : 0;  // "max" is no number
}

}  // namespace

MemoryEstimate estimate_memory(const SetupSize& size, int real_bytes) {
  const double r = real_bytes, index = 4, quanta = 8;
  const double fluid = 1.25 * size.fluid, s = size.support;
  const bool with_samples = size.samples > 0 && size.searches_samples, with_fluid = size.fluid > 0;
  // Neighbours in full surroundings: of liquid, of a wall's layers on one side, of one sheet.
  const double in_liquid = width(4.0 / 3 * pi * s * s * s), in_wall = width(2.0 / 3 * pi * s * s * s),
               in_sheet = width(pi * s * s);
  MemoryEstimate m;
  // FluidArrays twice 10 r + 17, FluidWork 21 r + 1, an index; per particle. And the ledger's partial sums.
  m.particles = fluid * (41 * r + 39) + (56 + 6 * r) * (std::min(65536.0, size.fluid) + std::min(65536.0, size.nodes));
  if (with_samples) m.particles += fluid * (9 * r + 2 * index + 1);  // AdvectionWork, nearest_sample
  // Lists with slopes beside their entries; where cloth exchanges liquid, also what each entry passes on.
  m.lists = fluid * in_liquid * (index + r);
  if (size.boundary > 0) m.lists += fluid * in_wall * (index + r);
  if (with_samples && with_fluid)
    m.lists += fluid * in_sheet * (index + r + (size.exchange ? quanta : 0)) + size.samples * in_liquid * (index + r);
  if (with_samples) m.lists += size.samples * in_sheet * index;
  if (with_samples && size.boundary > 0) m.lists += size.samples * in_wall * index;
  for (const double points : {size.fluid, size.boundary, with_samples ? size.samples : 0.0})
    if (points > 0) m.cells += table_bytes(1.25 * points, r);
  m.bodies = size.boundary * (10 * r + index) + size.field * r;
  // A node has about three edges, three hinges and two triangles.
  m.cloth = size.nodes * (100 * r + 380) + size.samples * (30 * r + 60);
  if (size.exchange) m.cloth += size.samples * (9 * r + 16 * quanta);
  if (size.diffusion) m.cloth += size.nodes * 220;
  if (size.xpbd) m.cloth += size.nodes * 48 * r;
  if (size.self_collision) m.cloth += size.nodes * (60 * r + 300 + 30 * 117);  // 30 pairs a node; folds may have more
  // HostState has 97 bytes a particle, the set-up beside it a third of that; a frame is a state and its grid.
  m.host = size.fluid * 130 + size.boundary * 130 + size.nodes * 900 + size.samples * 330 + size.field * 8;
  if (size.frames) m.host += size.fluid * 200 + size.boundary * 60 + size.nodes * 350 + size.samples * 40;
  return m;
}

double machine_memory() {
  const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  const double limit = number_in("/sys/fs/cgroup/memory.max");
  return limit > 0 ? std::min(limit, machine) : machine;
}

double machine_memory_free() {
  std::ifstream in("/proc/meminfo");
  std::string key;
  double kibibytes = 0, free = machine_memory();
  for (std::string unit; in >> key >> kibibytes; std::getline(in, unit))
    if (key == "MemAvailable:") free = std::min(free, 1024 * kibibytes);
  if (const double limit = number_in("/sys/fs/cgroup/memory.max"); limit > 0)
    free = std::min(free, std::max(0.0, limit - number_in("/sys/fs/cgroup/memory.current")));
  return free;
}

void refuse_too_large(const SetupSize& size, const MemoryBudget& budget) {
  constexpr double most = 1 << 28, gibibyte = 1 << 30;
  const std::string counts = fmt::format(
      "{:.0f} liquid particles, {:.0f} samples of bodies, {:.0f} cloth nodes and {:.0f} "
      "samples of cloth{}",
      size.fluid, size.boundary, size.nodes, size.samples,
      size.field > 0 ? fmt::format(", {:.0f} points of distance fields", size.field) : "");
  if (!(size.fluid <= most && size.boundary <= most && size.nodes <= most / 4 && size.samples <= most &&
        size.field <= 8 * most)) {
    throw SetupError(
        fmt::format("the scene is too large: {}; allowed: {:.0f} of each, {:.0f} nodes", counts, most, most / 4));
  }
  const MemoryEstimate estimate = estimate_memory(size, budget.real_bytes);
  const bool shared = budget.device.empty();
  if (const double bytes = shared ? estimate.total() : estimate.host; bytes > budget.host)
    throw SetupError(
        fmt::format("the scene does not fit in memory: {} need about {:.1f} GiB, the machine has {:.1f} GiB", counts,
                    bytes / gibibyte, budget.host / gibibyte));
  if (const double bytes = estimate.backend(); !shared && bytes > budget.device_free)
    throw SetupError(
        fmt::format("the scene does not fit in the device's memory: {} need about {:.1f} GiB, {} has {:.1f} GiB free",
                    counts, bytes / gibibyte, budget.device, budget.device_free / gibibyte));
}

}  // namespace drench
