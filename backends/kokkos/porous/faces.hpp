#pragma once
// What cloth exchanges with liquid on each of its faces, counted where a scene asks for it (src/stages/fabric.hpp).

#include "porous/transfer.hpp"

namespace drench::kokkos_backend {

/// Is a place at `away` (m) on the front of a sample?
KOKKOS_INLINE_FUNCTION bool on_front(const Real3& normal, const Real3& away) { return dot(away, normal) >= 0; }

/// The faces of samples: the front is where the normal points. Empty where they are not counted.
struct Faces {
  Entries<const Real3> normal;
  Entries<Quanta> front;

  Faces(const Cloth& cloth, TransferWork& transfers) : normal(cloth.samples.normal), front(transfers.front) {}
  /// Sample p exchanges `mass` with liquid at `away` from it.
  KOKKOS_INLINE_FUNCTION void count(Index p, const Real3& away, Quanta mass) const {
    if (front.exist() && mass != 0 && on_front(normal(p), away)) Kokkos::atomic_add(&front(p), mass);
  }
};

/// What goes into new particles: each sample's own thread counts it.
struct FacesOfNew {
  Entries<Quanta> front, back;
  Entries<const Real3> position, normal;

  explicit FacesOfNew(Cloth& cloth)
      : front(cloth.samples.given_front),
        back(cloth.samples.given_back),
        position(cloth.samples.position),
        normal(cloth.samples.normal) {}
  KOKKOS_INLINE_FUNCTION void count(Index p, const Real3& particle, Quanta mass) const {
    if (front.exist()) (on_front(normal(p), particle - position(p)) ? front : back)(p) += mass;
  }
};

/// transfers.front is 0 everywhere; nothing where the cloth does not count.
void clear_faces(const Cloth& cloth, TransferWork& transfers);
/// Adds what samples took in, arriving(p), to their accounts: transfers.front of it on the front.
void count_taken(Cloth& cloth, TransferWork& transfers);
/// Adds the difference between what samples had to give, `had`, and have left, `left`, to their accounts.
void count_given(Cloth& cloth, TransferWork& transfers, const Field<Quanta>& had, const Field<Quanta>& left);

}  // namespace drench::kokkos_backend
