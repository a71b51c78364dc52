#pragma once
// What cloth exchanges with liquid on each of its faces, counted where a scene asks for it (src/stages/fabric.hpp).

#include "porous/transfer.hpp"

namespace drench::kokkos_backend {

/// The faces of samples: the front is where the normal points. Empty where they are not counted.
struct Faces {
  Entries<const Real3> normal;
  Entries<Quanta> front;

  Faces(const Cloth& cloth, TransferWork& transfers) : normal(cloth.samples.normal), front(transfers.front) {}
  /// Is `away` from sample p (m) on its front?
  KOKKOS_INLINE_FUNCTION bool faces(Index p, const Real3& away) const { return dot(away, normal(p)) >= 0; }
  /// Sample p exchanges `mass` with liquid at `away` from it.
  KOKKOS_INLINE_FUNCTION void count(Index p, const Real3& away, Quanta mass) const {
    if (front.exist() && mass != 0 && faces(p, away)) Kokkos::atomic_add(&front(p), mass);
  }
};

/// transfers.front is 0 everywhere; nothing where the cloth does not count.
void clear_faces(const Cloth& cloth, TransferWork& transfers);
/// Adds what samples took in, arriving(p), to their accounts: transfers.front of it on the front.
void count_taken(Cloth& cloth, TransferWork& transfers);
/// Adds the difference between what samples had to give, `had`, and have left, `left`, to their accounts.
void count_given(Cloth& cloth, TransferWork& transfers, const Field<Quanta>& had, const Field<Quanta>& left);

}  // namespace drench::kokkos_backend
