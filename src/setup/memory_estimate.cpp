#include "setup/memory_estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "setup/setup_error.hpp"

namespace drench {
namespace {

constexpr double pi = 3.14159265358979323846;

constexpr double index = 4, quanta = 8, number = 8;  // bytes: Index; 64-bit integers; double

/// Of a cell table of `points` with the counting sort: item, its exchange (on a GPU), bucket and point of each, in a hashed
/// table its cell; start of each cell.
double table_bytes(double points, double cells, double r, bool gpu) {
  if (points <= 0) return 0;
  const bool hashed = !(cells > 0);
  return 1.25 * points * (3 * index + (hashed ? 12 : 0) + (gpu ? 4 : 3) * r) +
         1.25 * index * (hashed ? 2 * points : cells);
}

/// The neighbour lists' part, with what is kept beside their entries.
double list_bytes(const SetupSize& size, double r, bool gpu) {
  const double s = size.support, crowd = size.crowding;
  const double samples_there = size.area > 0 ? std::max(1.0, size.samples / size.area) : 1;  // a d²
  const double in_liquid = crowd * 4.0 / 3 * pi * s * s * s, on_a_side = 0.5 * in_liquid,
               at_sheet = std::min(size.samples, pi * s * s * samples_there);
  const auto bundled = [&](double own) { return gpu ? 1.1 * own : own; };  // of the paper's scenes on an H200
  const ListEntries& known = size.entries;
  const auto counted = [&](const RowEntries& row, double unknown) {
    return row.own < 0 ? bundled(unknown) : gpu ? row.bundled : row.own;
  };
  // Pairs of liquid with a surface: as many as this finds, and as the liquid has neighbours in it. (0.7: of two layers within
  // h = 2 d the one at d/2 has 0.94 and the one at 3/2 d 0.44 of a disk of radius h.)
  const auto touching = [&](double points, double at_surface) {
    return bundled(std::min(points * on_a_side, 0.7 * size.fluid * at_surface));
  };
  const auto met = [&](const RowEntries& row, double rows, double pairs) {
    return std::max(rows * counted(row, pairs / std::max(rows, 1.0)), size.contact ? pairs : 0);
  };
  const auto list = [&](double rows, double entries, double bytes) {
    return 1.25 * rows * (index + (gpu ? quanta / list_bundle : quanta)) + 1.25 * entries * bytes;
  };
  const bool fluid = size.fluid > 0, samples = size.samples > 0 && size.searches_samples, walls = size.boundary > 0;
  double bytes = 0;
  if (fluid)
    bytes +=
        list(size.fluid, crowd * size.fluid * counted(known.fluid_fluid, in_liquid / crowd), index + r);  // with slopes
  if (fluid && walls)
    bytes += list(size.fluid, met(known.fluid_boundary, size.fluid, touching(size.boundary, pi * s * s)), index);
  if (samples) bytes += list(size.samples, size.samples * counted(known.sample_sample, at_sheet), index);
  if (samples && size.liquid) {
    const double pairs = touching(size.wet_sides * size.samples, at_sheet),
                 of_liquid = met(known.fluid_sample, size.fluid, pairs);
    bytes += list(size.samples, met(known.sample_fluid, size.samples, pairs), index);
    const double beside = 3 * r + (size.absorption ? quanta : 0);  // gradients and offers
    if (fluid) bytes += list(size.fluid, of_liquid, index + beside);
    if ((size.absorption || size.emission) && size.direction && walls)
      bytes += list(size.samples,
                    met(known.sample_boundary, size.samples,
                        bundled(std::min(size.samples * pi * s * s, size.boundary * at_sheet))),
                    index);
  }
  if (fluid && size.dynamic_samples > 0)
    bytes += list(size.dynamic_samples, bundled(size.dynamic_samples * on_a_side), index);
  return bytes;
}

double particle_bytes(const SetupSize& size, double r, bool gpu) {
  if (size.fluid <= 0) return 0;
  double each = 2 * (10 * r + 17) + 21 * r + 1;         // FluidArrays and their spare ones, FluidWork
  each += 3 * r + 1;                                    // AdvectionWork
  if (size.samples > 0) each += 13 * r + index;         // the same, SheetContact, nearest_sample
  if (size.samples > 0 && gpu) each += index;           // who may hit the cloth
  if (size.emission) each += 5 * quanta;                // EmissionWork
  if (size.absorption || size.emission) each += index;  // compact_source
  if (size.measures) each += 2 * r;
  if (size.micropolar) each += 2 * 3 * r + 8 * r;  // spins and their spare ones, MicropolarWork
  return (1.25 * size.fluid + 64) * each;
}

double body_bytes(const SetupSize& size, double r) {
  double bytes = size.boundary * (10 * r + index) + size.field * r;
  if (size.dynamic_samples > 0) bytes += size.dynamic_samples * (8 * r + 2 * index) + size.boundary * 3 * r;
  return bytes;
}

double cloth_bytes(const SetupSize& size, double r, bool gpu) {
  if (size.nodes <= 0) return 0;
  const auto counted = [&](double count, double a_node) { return count > 0 ? count : a_node * size.nodes; };
  const double edges = counted(size.edges, 3), hinges = counted(size.hinges, 3), links = counted(size.links, 12),
               triangles = counted(size.triangles, 2), pairs = counted(size.fabric_pairs, 3);
  double node = 5 * 3 * r + 2 * quanta + r + 1 + index + number + 7 * r + 3 * index;  // NodeArrays
  if (size.samples > 0) node += 2 * quanta + number + index + r;
  if (size.moving_cloth) node += 15 * r;                                     // ClothWork
  if (size.moving_cloth || size.liquid) node += 3 * r + 3 * quanta + index;  // AdvectionWork
  if (size.absorption || size.emission) node += number;                      // TransferWork
  if (size.measures) node += 2 * number;
  if (size.diffusion) node += 2 * number + index + (size.moving_cloth ? 6 * number : 0);
  if (size.contact_wicking) node += 2 * quanta + (size.moving_cloth ? 3 * quanta : 0);
  if (size.wet_adhesion) node += r + 3 * quanta;
  double bytes = size.nodes * node;
  bytes += edges * (4 * index + 2 * r) + hinges * (8 * index + 5 * r) + links * 4 * r;
  bytes += triangles * (3 * index + 3 * r + (size.strain_limit ? 4 * r + 3 * index : 0));
  if (size.moving_cloth && gpu && !size.xpbd)
    bytes += size.nodes * (8 * r + 3 * index) + links * index / 2;  // ResidentCloth: two iterates, patches
  if (size.xpbd) bytes += (edges + hinges) * 7 * r + (size.strain_limit ? triangles * 14 * r : 0);
  if (size.diffusion) bytes += pairs * (4 * index + 2 * number + quanta);

  double sample = 3 * index + index + 3 * r + 3 * number + index + 9 * r + 3 * index;  // SampleArrays, node_samples
  if (size.liquid) sample += 19 * r + 2 * index;                                       // and ViscousWork, boundary edges
  if (size.porous) sample += 9 * r;
  if (size.absorption || size.emission) sample += 4 * quanta + number;  // TransferWork
  if (size.emission) sample += 6 * quanta + 3 * r + 1 + 3 * index;      // EmissionWork
  if (size.emission && size.direction && size.boundary > 0) sample += 3 * r;
  if (size.contact_wicking) sample += 2 * (index + 5 * number + quanta);
  bytes += size.samples * sample;

  if (size.self_collision) {  // as if all took part
    bytes += size.nodes * (3 * number + 6 * r + 3 * quanta + 2 * index + 1 + 9 * r) + edges * (9 * r + 2 * index) +
             triangles * 3 * index;
    bytes += (size.fold_pairs * size.nodes + 1024) * 117;
  }
  if (size.wet_adhesion) bytes += triangles * (3 * index + 3 * r);
  return bytes;
}

double all_table_bytes(const SetupSize& size, double r, bool gpu) {
  double bytes = table_bytes(size.fluid, size.fluid_cells, r, gpu) * (size.measures ? 2 : 1);
  bytes += table_bytes(size.boundary, size.boundary_cells, r, gpu);
  if (size.searches_samples) bytes += table_bytes(size.samples, size.sample_cells, r, gpu);
  if (size.self_collision)
    bytes += table_bytes(size.nodes, 0, r, gpu) + table_bytes(size.edges > 0 ? size.edges : 3 * size.nodes, 0, r, gpu);
  if (size.wet_adhesion) bytes += table_bytes(size.triangles > 0 ? size.triangles : 2 * size.nodes, 0, r, gpu);
  return bytes;
}

/// Partial sums of the ledger (backends/kokkos/primitives/reduce.hpp, ledger.hpp), one range for the liquid and one for the
/// cloth's nodes and edges.
double sum_bytes(const SetupSize& size, double r, bool gpu) {
  const double edges = size.moving_cloth ? (size.edges > 0 ? size.edges : 3 * size.nodes) : 0;
  double sums = 0;
  for (const double most : {size.fluid, std::max(size.nodes, edges)})
    sums +=
        gpu ? std::min(512.0, most / 128 + 1) : std::min(65536.0, most) + std::min(1024.0, most) + std::min(32.0, most);
  return 1.25 * (11 * number + 6 * r) * sums;
}

/// Reads one number from a file of the kernel's; 0 without one.
double number_in(const char* path) {
  std::ifstream in(path);
  double value = 0;
  return in >> value ? value : 0;  // "max" is no number
}

}  // namespace

MemoryEstimate estimate_memory(const SetupSize& size, int real_bytes, bool gpu) {
  const double r = real_bytes;
  MemoryEstimate m;
  m.particles = particle_bytes(size, r, gpu) + sum_bytes(size, r, gpu);
  m.lists = list_bytes(size, r, gpu);
  m.cells = all_table_bytes(size, r, gpu);
  m.bodies = body_bytes(size, r);
  m.cloth = cloth_bytes(size, r, gpu);
  // HostState has 97 bytes a particle, the set-up beside it a third of that; a frame is a state, its grid and,
  // while it is written, its file twice.
  m.host = size.fluid * 130 + size.boundary * 130 + size.nodes * 900 + size.samples * 330 + size.field * 8;
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
      "{:.0f} liquid particles, {:.0f} samples of bodies, {:.0f} cloth nodes and {:.0f} "
      "samples of cloth{}",
      size.fluid, size.boundary, size.nodes, size.samples,
      size.field > 0 ? fmt::format(", {:.0f} points of distance fields", size.field) : "");
  const double of_spacing = size.fluid + size.boundary + size.samples + size.field;
  const char* key = size.liquid && of_spacing > size.nodes ? "fluid.spacing" : "cloth";
  if (!(size.fluid <= most && size.boundary <= most && size.nodes <= most / 4 && size.samples <= most &&
        size.field <= 8 * most)) {
    throw SetupError(
        fmt::format("the scene is too large: {}; allowed: {:.0f} of each, {:.0f} nodes", counts, most, most / 4), key);
  }
  const MemoryEstimate estimate = estimate_memory(size, budget.real_bytes, !budget.device.empty());
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
