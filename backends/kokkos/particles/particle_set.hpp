#pragma once
// The liquid's particles on the device, made from the table of their fields (src/state/fields.hpp).

#include "core/cached.hpp"
#include "core/sizing.hpp"
#include "core/types.hpp"
#include "state/needed_fields.hpp"

namespace drench::kokkos_backend {

/// One particle, with a value for each field. A new one begins at 0 in all of them.
struct Particle {
#define DRENCH_VALUE(owner, name, host_type, unit, needed) OnDevice<host_type>::type name{};
  DRENCH_PARTICLE_FIELDS(DRENCH_VALUE)
#undef DRENCH_VALUE
};

/// The arrays as kernels see them; those that the model does not need do not exist.
struct ParticleView {
#define DRENCH_ENTRIES(owner, name, host_type, unit, needed) Entries<OnDevice<host_type>::type> name;
  DRENCH_PARTICLE_FIELDS(DRENCH_ENTRIES)
#undef DRENCH_ENTRIES

  /// All fields at once: a compiler cannot move loads past stores that might be to the same memory.
  KOKKOS_INLINE_FUNCTION Particle load(Index i) const {
    Particle p;
#define DRENCH_LOAD(owner, name, host_type, unit, needed) \
  if (name.exist()) p.name = name(i);
    DRENCH_PARTICLE_FIELDS(DRENCH_LOAD)
#undef DRENCH_LOAD
    return p;
  }
  KOKKOS_INLINE_FUNCTION void store(Index i, const Particle& p) const {
#define DRENCH_STORE(owner, name, host_type, unit, needed) \
  if (name.exist()) name(i) = p.name;
    DRENCH_PARTICLE_FIELDS(DRENCH_STORE)
#undef DRENCH_STORE
  }
};

/// Arrays are at least `count` long; capacity grows between steps. From stage neighbors on the particles lie in the
/// order of their cells, with later ones behind. HostState has them by id.
class ParticleSet {
 public:
  /// `over_ranks`: particles come from other ranks.
  ParticleSet(const Model& m, bool over_ranks);

#define DRENCH_FIELD(owner, name, host_type, unit, needed) Field<OnDevice<host_type>::type> name;
  DRENCH_PARTICLE_FIELDS(DRENCH_FIELD)
#undef DRENCH_FIELD

  Index count = 0;           // owned
  Index ghosts = 0;          // behind them: copies of other ranks' particles, from stage neighbors to advection
  std::int64_t total = 0;    // owned, of all ranks
  std::int64_t next_id = 0;  // the same on all ranks
  Version moved;             // of the positions, as steps begin

  void upload(const HostState& s);
  void download(HostState& s) const;

  /// Owned and ghosts.
  Index local() const { return count + ghosts; }
  ParticleView view();
  std::size_t capacity() const { return position.extent(0); }
  /// Makes room for `n` particles, keeping what is there: no more than these at first where none can come, else
  /// amortised growth.
  void reserve(Index n);
  /// Removes particles with mass 0 or with `gone(i)` ≠ 0 (may be empty), keeping the order. Lists become stale.
  /// `kept`: how many stay, where that is known; else the host waits for their number.
  void compact(Slice<const std::uint8_t> gone, Index kept = -1);
  /// Particle i, owned or ghost, becomes what `source(i)` was; `source(i)` becomes i.
  void reorder(const Array<Index>& source);
  /// The place of each particle, as it lies in memory, among them by id.
  std::vector<Index> ranks_by_id() const;

 private:
  // Calls visit(name, array, spare) for each field that the model needs.
  template <class Visitor>
  void visit_needed(Visitor&& visit);
  void gather(const Array<Index>& source, Index n);

  const Model& model_;
  bool grows_;           // there may be more particles than at first
  Field<Index> source_;  // scratch of `compact`
#define DRENCH_SPARE(owner, name, host_type, unit, needed) Field<OnDevice<host_type>::type> spare_##name;
  DRENCH_PARTICLE_FIELDS(DRENCH_SPARE)  // what `gather` writes to, kept between steps
#undef DRENCH_SPARE
};

/// The liquid's arrays of a state in the order of ids.
void sort_by_id(HostState& s);

/// Entries of an array that is as long as the particles' own.
double particle_room(const Sizing& s);
MemoryEstimate particle_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
