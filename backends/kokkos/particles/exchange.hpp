#pragma once
// Which rank owns which particles, and what travels between ranks. Alone nothing here allocates, launches or waits.
// Design: docs/dev/distribution.md.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/constants.hpp"
#include "core/neighbor_list.hpp"
#include "parallel/bisection.hpp"
#include "particles/device_messages.hpp"
#include "particles/particle_set.hpp"

namespace drench::kokkos_backend {

/// A rank's part of space: min ≤ x < max on each axis, with infinite sides. Together they fill space.
struct RankBox {
  Real3 min{-INFINITY, -INFINITY, -INFINITY}, max{INFINITY, INFINITY, INFINITY};

  KOKKOS_INLINE_FUNCTION bool holds(const Real3& x) const {
    return !(x.x < min.x || x.y < min.y || x.z < min.z || x.x >= max.x || x.y >= max.y || x.z >= max.z);
  }
  /// Is the point within `reach` of it?
  KOKKOS_INLINE_FUNCTION bool near(const Real3& x, Real reach) const {
    return beside(x.x, min.x, max.x, reach) && beside(x.y, min.y, max.y, reach) && beside(x.z, min.z, max.z, reach);
  }

 private:
  KOKKOS_INLINE_FUNCTION static bool beside(Real x, Real min, Real max, Real reach) {
    return x - min > -reach && x - max < reach;
  }
};

/// The values that are ghosts elsewhere, side by side. (No lambda: nvcc's belong to one file.)
template <class T>
struct PackGhosts {
  Entries<const T> from;
  Entries<const Index> item;
  T* to;
  KOKKOS_INLINE_FUNCTION void operator()(const Index k) const { to[k] = from(item(k)); }
};

/// Rows from `first` on.
template <class Body>
struct RowsFrom {
  Body body;
  Index first;
  KOKKOS_INLINE_FUNCTION void operator()(const Index k) const { body(first + k); }
};

class Exchange {
 public:
  explicit Exchange(const Constants& constants);

  bool alone() const { return ranks_ == nullptr; }
  const Communicator* ranks() const { return ranks_; }
  /// This rank's part of space; all of it when alone.
  const RankBox& own() const { return own_; }

  /// What particles travel by, in a line; "" when alone.
  std::string transport() const;
  /// Particles of the fullest rank over the mean, 1; how often space was cut anew.
  double imbalance() const { return imbalance_; }
  std::int64_t cuts() const { return cuts_; }

  /// Particles of a state that every rank has whole: cuts space, and uploads this rank's own.
  void upload_own(const HostState& state, ParticleSet& particles);
  /// Particles go to the ranks that own their places; cuts anew where one rank has a tenth more than the mean.
  void migrate(ParticleSet& particles);
  /// Copies of the particles of other ranks within h + `more` (m) come behind the owned ones: positions, masses and
  /// ids.
  void find_ghosts(ParticleSet& particles, Real more = 0);
  /// The owned come into the order that they have in `item`, a table's of all: first those that are far from other
  /// ranks' parts, then the others. The entries of `item` become what they are then.
  void sort_owned(ParticleSet& particles, const Array<Index>& item);
  /// The ghosts' values of a field, from their owners.
  template <class T>
  void halo(Field<T>& values) const {
    begin_halo(values);
    finish_halo();
  }
  /// The same in two parts, between which rows without ghosts may be computed. One at a time: what else travels
  /// finishes it.
  template <class T>
  void begin_halo(Field<T>& values) const {
    if (alone()) return;
    begin_packing();
    make_ample_room(packed_, "drench::exchange::packed", static_cast<std::size_t>(sent_count_) * sizeof(T));
    parallel("drench::exchange::pack", sent_count_,
             PackGhosts<T>{std::as_const(values), sent_, reinterpret_cast<T*>(packed_.data())});
    begin_travel(packed_, sent_to_, values.data() + first_ghost_, from_, sizeof(T));
  }
  void finish_halo() const;
  /// The owned rows before this have no ghost among their neighbours; a multiple of a warp, 0 where messages are not
  /// worth it. Alone: all `count`.
  Index inner(Index count) const { return alone() ? count : inner_; }
  /// Runs `body(i)` for the rows up to inner().
  template <class Body>
  void inner_rows(const char* label, Index count, const Body& body) const {
    parallel(label, inner(count), body);
  }
  /// Runs `body(i)` for the others.
  template <class Body>
  void outer_rows(const char* label, Index count, const Body& body) const {
    if (!alone()) parallel(label, count - inner_, RowsFrom<Body>{body, inner_});
  }
  /// Empties the rows over liquid of other ranks' samples: the rank that owns a place has all the liquid around it.
  void keep_own_rows(const Field<Real3>& position, NeighborList& list) const;
  /// Integers that each rank has summed up for itself become the sums of all.
  void add_up(Field<std::int64_t>& sums, Index count) const {
    if (!alone()) add_up_words(sums.data(), static_cast<std::size_t>(count));
  }
  void add_up(Field<Index>& sums, Index count) const;
  /// Results of rows that one rank each has found: the others have zeros there, and get them.
  template <class T>
  void share(Field<T>& values, Index count) const {
    if (!alone()) share_bytes(values.data(), static_cast<std::size_t>(count) * sizeof(T));
  }
  /// Those that are not at home go there. (Public for nvcc's sake.)
  void send_home(ParticleSet& particles);
  /// Those that came take the places of those that `left` (ascending), then the last ones do. (The same.)
  void settle(ParticleSet& particles, const std::vector<Index>& left, Index come);
  /// All ranks' particles in the state of rank 0, in the order of their ids.
  void gather(HostState& state) const;

 private:
  /// The time until the bytes travel counts as packing.
  void begin_packing() const;
  /// Bytes from device memory to other ranks and back, `each` an item: those of the first rank first.
  void travel(const Array<std::byte>& sent, const std::vector<std::int64_t>& to, void* received,
              const std::vector<std::int64_t>& from, std::size_t each) const;
  /// The same in two parts, of which finish_halo() is the second.
  void begin_travel(const Array<std::byte>& sent, const std::vector<std::int64_t>& to, void* received,
                    const std::vector<std::int64_t>& from, std::size_t each) const;
  void begin_on_device(const std::vector<Message>& sent, const std::vector<Message>& received) const;
  void share_bytes(void* data, std::size_t bytes) const;
  void add_up_words(std::int64_t* sums, std::size_t count) const;
  void take_boxes(const Bisection& space);
  void cut_anew(const ParticleSet& particles);
  void count_all(ParticleSet& particles, double& fullest) const;

  const Communicator* ranks_;
  std::unique_ptr<DeviceMessages> device_;  // null: by the host's memory
  bool overlaps_ = false;  // do messages take long enough to go beside kernels? Not between the GPUs of one host
  Real support_;           // h, m
  RankBox own_;
  Field<RankBox> boxes_;
  std::vector<RankBox> host_boxes_;
  Field<Index> chosen_, home_, order_;  // particles that leave, or may be ghosts; where they belong; who come first
  Field<Index> sent_;                   // those that are ghosts elsewhere, one rank after the other
  Index sent_count_ = 0, first_ghost_ = 0;
  Index inner_ = 0, near_others_ = 0;         // rows without ghosts; the rest, but for what fills up a warp
  std::vector<std::int64_t> sent_to_, from_;  // how many, of each rank
  std::vector<Field<Index>> parts_;           // of `chosen_`, by the rank that they are ghosts on
  Field<std::uint8_t> outer_;                 // whether a particle is near another rank's part
  Array<std::byte> arrived_;
  mutable Field<std::int64_t> wide_;
  double imbalance_ = 1, left_by_cut_ = 1;
  std::int64_t cuts_ = 0;
  mutable double begin_ = -1;  // s, of the packing under way
  mutable bool under_way_ = false;
  mutable void* arriving_ = nullptr;  // where bytes are on their way to
  mutable std::size_t arriving_bytes_ = 0;
  mutable Array<std::byte> packed_;
  mutable Kokkos::View<std::byte*, Kokkos::SharedHostPinnedSpace> out_, in_;  // of a GPU's, on their way
};

/// What Exchange takes on a rank with so many particles and ghosts; as many ghosts are sent as come.
double exchange_bytes(double owned, double ghosts, double real_bytes);

}  // namespace drench::kokkos_backend
