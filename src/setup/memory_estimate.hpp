#pragma once
// How much memory a scene will take, counted before anything of its size is allocated.

#include <cstdint>
#include <functional>
#include <string>

#include "scene/scene.hpp"

namespace drench {

/// How many rows of a list a GPU bundles, as wide as the longest of them: the rows that RowEntries::bundled is counted
/// over.
inline constexpr std::size_t list_bundle = 32;

/// Entries of a list a row, on average: as many as it has neighbours, and as many as the longest row of its bundle.
/// Below 0: not known.
struct RowEntries {
  double own = -1, bundled = -1;
};
struct ListEntries {
  RowEntries fluid_fluid, fluid_boundary, fluid_sample, sample_fluid, sample_sample, sample_boundary;
};

/// Counts of what a scene holds; doubles, since a bad scene's may overflow any integer. 0: not known yet, or none.
struct SetupSize {
  double fluid = 0, boundary = 0, nodes = 0, samples = 0;
  double triangles = 0, edges = 0, stitches = 0, hinges = 0;  // of the cloths
  double links = 0;            // pairs of nodes, twice each, that share an edge or a hinge
  double patches = 0;          // materials besides the cloths' own
  double fabric_pairs = 0;     // of nodes, that diffusion goes between
  double area = 0;             // of the cloths that are sampled, in d²
  double dynamic_samples = 0;  // of the boundary: those of dynamic bodies
  Scene scene;                 // for the keys of a stage that no count here tells of
  double field = 0;            // lattice points of the meshes' distance fields
  double part_field = 0;       // the same of their second parts
  // of bodies that change their shape: points of their lattices, of a mesh and of all files, triangles, and pairs of a
  // triangle with a block of a lattice that it is near
  double deforming_field = 0, deforming_points = 0, deforming_files = 0, deforming_triangles = 0, deforming_pairs = 0;
  double fluid_cells = 0, boundary_cells = 0, sample_cells = 0;  // of their cell tables
  double support = 2;                                            // h / d: how wide neighbour lists are
  ListEntries entries;                                           // as it begins
  double crowding = 1;           // so many times as many neighbours has liquid that splashes
  bool contact = false;          // liquid lies at all cloth and walls, as far as there is enough
  double wet_sides = 1;          // of the cloth, then: 2 of one without pins, which liquid flows round
  double fold_pairs = 8;         // pairs of the cloth with itself, a node; there is room for a quarter more
  bool searches_samples = true;  // liquid or other layers look for the cloth's samples
  bool moving_cloth = true;
  bool porous = false;
  bool liquid = true;  // there is, or may come
  bool absorption = false, emission = false, permeation = false, solute = false;
  bool adds_particles = true;  // there may be more than `fluid`
  bool evaporation = false;    // from liquid and from porous cloth
  bool direction = false;      // the cloth looks for solids
  bool diffusion = false, contact_wicking = false, films = false, squeezing = false, hysteresis = false;
  bool suction = false, narrowing = false, expands = false;  // of pores; of pores that stretch; of wet fabric
  bool self_collision = false, xpbd = false, strain_limit = false, wet_adhesion = false;
  bool membrane = false, softens = false, plate = false;  // of cloth; softens: where it is wet
  bool measures = false, fabric = false;
  bool frames = false;   // one is kept on the host while it is written
  bool surface = false;  // with the liquid's surface
  bool micropolar = false;
  double wall_planes = 0;  // of each sample of the boundary: where a body slips 1, and 2 if one moves
};

/// Entries of each neighbour list in all; boundary_fluid's rows are the samples of dynamic bodies.
struct ListTotals {
  double fluid_fluid = 0, fluid_boundary = 0, fluid_sample = 0, sample_fluid = 0, sample_sample = 0,
         sample_boundary = 0, boundary_fluid = 0;
};
/// As counted; a list that was not counted is taken as full: liquid all around, on one side of a wall, at a sheet.
/// `bundled`: with rows as wide as the longest of their bundle.
ListTotals expected_entries(const SetupSize& size, bool bundled);

/// The same with the parts of cloth meshes that are not counted yet: as many as a grid of these nodes has.
SetupSize with_expected_mesh(SetupSize size);

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
  MemoryEstimate& operator+=(const MemoryEstimate& o) {
    particles += o.particles;
    lists += o.lists;
    cells += o.cells;
    bodies += o.bodies;
    cloth += o.cloth;
    host += o.host;
    return *this;
  }
};

/// What a backend's arrays take for a scene of this size; `host`: what it keeps beside them. The backend tells it
/// (pipeline/backend.hpp).
using ArrayBytes = std::function<MemoryEstimate(const SetupSize&)>;

/// The memory of a run: the arrays, if there is who tells them, and what the host holds beside them. Growth during the
/// run is left out: with_sources, at_work and in_folds add it.
MemoryEstimate estimate_memory(const SetupSize& size, const ArrayBytes& arrays);

/// Bytes of memory of this machine, or of the part of it that this program may use (control groups).
double machine_memory();
/// Of these, what is free now.
double machine_memory_free();

/// The memory that a run may take. By default: the memory of this machine, for the set-up alone.
struct MemoryBudget {
  int real_bytes = 4;              // of the backend's numbers
  double host = machine_memory();  // bytes
  std::string device;              // the name of a device that has memory of its own; "" if the host's is used
  double device_free = 0;          // bytes
  ArrayBytes arrays;               // of the backend; empty: none is counted
};

/// SetupError when the estimate is above the budget, or a count above what an Index can number (2^28 of each kind: four
/// corners of a hinge share one Index).
void refuse_too_large(const SetupSize& size, const MemoryBudget& budget);

}  // namespace drench
