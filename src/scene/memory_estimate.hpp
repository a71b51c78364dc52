#pragma once
// How much memory a scene will take, counted before anything of its size is allocated.

#include <cstdint>
#include <string>

namespace drench {

/// Counts of what a scene holds; doubles, since a bad scene's may overflow any integer.
struct SetupSize {
  double fluid = 0, boundary = 0, nodes = 0, samples = 0;
  double field = 0;              // lattice points of the meshes' distance fields
  double support = 2;            // h / d: how wide neighbour lists are
  bool searches_samples = true;  // liquid or other layers look for the cloth's samples
  bool exchange = false;         // liquid and porous cloth pass liquid to each other
  bool diffusion = false;
  bool self_collision = false, xpbd = false;
  bool frames = false;  // one is kept on the host while it is written
};

/// Bytes. All but `host` is the backend's: on a GPU in its own memory.
struct MemoryEstimate {
  double particles = 0;  // arrays of the liquid and of its stages
  double lists = 0;      // neighbour lists with what is kept beside their entries
  double cells = 0;      // cell tables
  double bodies = 0;     // samples and distance fields
  double cloth = 0;      // nodes, edges, hinges, samples
  double host = 0;       // the set-up, and the frame that is being written
  double backend() const { return particles + lists + cells + bodies + cloth; }
  double total() const { return backend() + host; }
};

/// What a run with numbers of `real_bytes` (4 or 8) takes, item by item as backends/kokkos/device.hpp allocates them: arrays of the
/// liquid a quarter longer than it is, lists a quarter wider than 1.3 times the neighbours in full surroundings. Small
/// work arrays are left out. Particles that jets and cloths will add later are not counted.
MemoryEstimate estimate_memory(const SetupSize& size, int real_bytes);

/// Bytes of memory of this machine, or of the part of it that this program may use (control groups).
double machine_memory();
/// Of these, what is free now.
double machine_memory_free();

/// What a run may take. By default: a backend in single precision in the memory of this machine.
struct MemoryBudget {
  int real_bytes = 4;
  double host = machine_memory();  // bytes
  std::string device;              // the name of a device that has memory of its own; "" if the host's is used
  double device_free = 0;          // bytes
};

/// SetupError when the estimate is above the budget, or a count above what an Index can number (2^28 of each kind: four
/// corners of a hinge share one Index).
void refuse_too_large(const SetupSize& size, const MemoryBudget& budget);

}  // namespace drench
