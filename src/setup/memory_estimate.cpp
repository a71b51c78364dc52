#include "setup/memory_estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "setup/setup_error.hpp"

namespace drench {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Reads one number from a file of the kernel's; 0 without one.
double number_in(const char* path) {
  std::ifstream in(path);
  double value = 0;
  return in >> value ? value : 0;  // "max" is no number
}

}  // namespace

ListTotals expected_entries(const SetupSize& size, bool bundled) {
  // Lists have a quarter more room than they need at first, and only liquid that comes makes them grow before that is
  // full.
  constexpr double first_room = 1.25;
  const double s = size.support, crowd = size.crowding;
  const double grown = !size.adds_particles && crowd <= first_room ? 1 : crowd;
  const double samples_there = size.area > 0 ? std::max(1.0, size.samples / size.area) : 1;  // a d²
  const double in_liquid = crowd * 4.0 / 3 * pi * s * s * s, on_a_side = 0.5 * in_liquid,
               at_sheet = std::min(size.samples, pi * s * s * samples_there);
  const auto widened = [&](double own) { return bundled ? 1.1 * own : own; };  // of the paper's scenes on an H200
  const auto counted = [&](const RowEntries& row, double unknown) {
    return row.own < 0 ? widened(unknown) : bundled ? row.bundled : row.own;
  };
  // Pairs of liquid with a surface: as many as this finds, and as the liquid has neighbours in it. (0.7: of two layers
  // within h = 2 d the one at d/2 has 0.94 and the one at 3/2 d 0.44 of a disk of radius h.)
  const auto touching = [&](double points, double at_surface) {
    return widened(std::min(points * on_a_side, 0.7 * size.fluid * at_surface));
  };
  const auto met = [&](const RowEntries& row, double rows, double pairs) {
    return std::max(rows * counted(row, pairs / std::max(rows, 1.0)), size.contact ? pairs : 0);
  };
  const ListEntries& known = size.entries;
  const double at_cloth = touching(size.wet_sides * size.samples, at_sheet),
               at_solids = widened(std::min(size.samples * pi * s * s, size.boundary * at_sheet));
  ListTotals all;
  all.fluid_fluid = grown * size.fluid * counted(known.fluid_fluid, in_liquid / crowd);
  all.fluid_boundary = met(known.fluid_boundary, size.fluid, touching(size.boundary, pi * s * s));
  all.fluid_sample = met(known.fluid_sample, size.fluid, at_cloth);
  all.sample_fluid = met(known.sample_fluid, size.samples, at_cloth);
  all.sample_sample = size.samples * counted(known.sample_sample, at_sheet);
  all.sample_boundary = met(known.sample_boundary, size.samples, at_solids);
  all.boundary_fluid = widened(size.dynamic_samples * on_a_side);
  return all;
}

SetupSize with_expected_mesh(SetupSize size) {
  const auto expect = [&](double& count, double a_node) {
    if (!(count > 0)) count = a_node * size.nodes;
  };
  expect(size.triangles, 2);
  expect(size.edges, 3);
  expect(size.hinges, 3);
  expect(size.links, 12);
  expect(size.fabric_pairs, 3);
  return size;
}

MemoryEstimate estimate_memory(const SetupSize& size, const ArrayBytes& arrays) {
  MemoryEstimate m = arrays ? arrays(size) : MemoryEstimate();
  // HostState has 97 bytes a particle, the set-up beside it a third of that; a frame is a state, its grid and,
  // while it is written, its file twice.
  m.host += size.fluid * 130 + size.boundary * 130 + size.nodes * 900 + size.samples * 330 + size.field * 8 +
            size.part_field * 8;
  if (size.part_field > 0) m.host += size.field * 8;  // at most: of the first parts
  if (size.frames) m.host += size.fluid * 300 + size.boundary * 120 + size.nodes * 500 + size.samples * 60;
  if (size.surface) m.host += size.fluid * 1000;  // of a pool some 300, of a splash with 10 points a particle 2200
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
      "{:.0f} fluid particles, {:.0f} boundary particles, {:.0f} cloth nodes and {:.0f} "
      "quadrature points of cloth{}",
      size.fluid, size.boundary, size.nodes, size.samples,
      size.field > 0 ? fmt::format(", {:.0f} points of distance fields", size.field) : "");
  const double of_spacing = size.fluid + size.boundary + size.samples + size.field;
  const char* key = size.liquid && of_spacing > size.nodes ? "fluid.spacing" : "cloth";
  if (!(size.fluid <= most && size.boundary <= most && size.nodes <= most / 4 && size.samples <= most &&
        size.field <= 8 * most)) {
    throw SetupError(
        fmt::format("the scene is too large: {}; allowed: {:.0f} of each, {:.0f} nodes", counts, most, most / 4), key);
  }
  const MemoryEstimate estimate = estimate_memory(size, budget.arrays);
  const bool shared = budget.device.empty();
  if (const double bytes = shared ? estimate.total() : estimate.host; bytes > budget.host)
    throw SetupError(
        fmt::format("the scene does not fit in memory: {} need about {:.1f} GiB, the machine has {:.1f} GiB", counts,
                    bytes / gibibyte, budget.host / gibibyte),
        key);
  if (const double bytes = estimate.backend(); !shared && bytes > budget.device_free)
    throw SetupError(
        fmt::format("the scene does not fit in the device's memory: {} need about {:.1f} GiB, {} has {:.1f} GiB free",
                    counts, bytes / gibibyte, budget.device, budget.device_free / gibibyte),
        key);
}

}  // namespace drench
