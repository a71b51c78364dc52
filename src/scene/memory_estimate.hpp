#pragma once
// How much memory a scene will take, counted before anything of its size is allocated.

#include <cstdint>

namespace drench {

/// Counts of what a scene holds; doubles, since a bad scene's may overflow any integer.
struct SetupSize {
  double fluid = 0, boundary = 0, nodes = 0, samples = 0;
  double field = 0;  // lattice points of the meshes' distance fields
};

/// Coarse: a run holds each item's state twice (host and backend) and its neighbour lists. 1,000 bytes for each liquid
/// particle, 200 for each boundary sample, 700 for each node with its edges and hinges, 800 for each cloth sample, 16 for
/// each point of a distance field.
/// Particles that jets and cloths will add later are not counted.
double estimated_bytes(const SetupSize& size);

/// Bytes of memory of this machine.
double machine_memory();

/// SetupError when the estimate is above `available` bytes, or a count above what an Index can number (2^28 of each
/// kind: four corners of a hinge share one Index).
void refuse_too_large(const SetupSize& size, double available);

}  // namespace drench
