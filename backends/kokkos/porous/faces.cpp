// Accounts of the cloth's two faces (src/stages/fabric.hpp).

#include "porous/faces.hpp"

namespace drench::kokkos_backend {

void clear_faces(const Cloth& cloth, TransferWork& transfers) {
  if (!cloth.samples.taken_front.exists()) return;
  make_room(transfers.front, "drench::fabric::front", static_cast<std::size_t>(cloth.samples.count));
  const Entries<Quanta> front = transfers.front;
  parallel(
      "drench::fabric::clear", cloth.samples.count, KOKKOS_LAMBDA(const Index p) { front(p) = 0; });
}

void count_taken(Cloth& cloth, TransferWork& transfers) {
  if (!cloth.samples.taken_front.exists()) return;
  const Entries<const Quanta> front = std::as_const(transfers).front;
  const Entries<Quanta> taken_front = cloth.samples.taken_front, taken_back = cloth.samples.taken_back;
  const Transfers exchange(cloth, transfers);
  parallel(
      "drench::fabric::taken", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        taken_front(p) += front(p);
        taken_back(p) += exchange.arriving(p) - front(p);
      });
}

void count_given(Cloth& cloth, TransferWork& transfers, const Field<Quanta>& had, const Field<Quanta>& left) {
  if (!cloth.samples.taken_front.exists()) return;
  const Entries<const Quanta> front = std::as_const(transfers).front, before = had, after = left;
  const Entries<Quanta> given_front = cloth.samples.given_front, given_back = cloth.samples.given_back;
  parallel(
      "drench::fabric::given", cloth.samples.count, KOKKOS_LAMBDA(const Index p) {
        given_front(p) += front(p);
        given_back(p) += before(p) - after(p) - front(p);
      });
}

}  // namespace drench::kokkos_backend
