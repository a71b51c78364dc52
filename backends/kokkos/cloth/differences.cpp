#include "cloth/differences.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <algorithm>
#include <cmath>
#include <cstring>

#define DRENCH_ISA_FILE "cloth/differences.inl"
#include "core/for_each_isa.hpp"

namespace drench::kokkos_backend {

Differences::Differences(Index nodes) {
  const std::size_t numbers = (3 * static_cast<std::size_t>(nodes) + spare_lanes - 1) / spare_lanes * spare_lanes;
  for (Numbers* a : {&shift_, &residual_, &descent_, &last_shift_, &last_residual_, &last_descent_}) a->resize(numbers);
}

void Differences::clear() {
  kept_ = next_ = 0;
  has_last_ = false;
}

void Differences::copy_last(Field<Real3>& shift) const {
  std::memcpy(static_cast<void*>(shift.data()), last_shift_.data(), shift.extent(0) * sizeof(Real3));
}

void Differences::step(Field<Real3>& shift, const Field<Real3>& residual, const Field<Real3>& descent) {
  const std::size_t bytes = shift.extent(0) * sizeof(Real3);
  std::memcpy(shift_.data(), shift.data(), bytes);
  std::memcpy(residual_.data(), residual.data(), bytes);
  std::memcpy(descent_.data(), descent.data(), bytes);
  const auto numbers = static_cast<Index>(shift_.size());
  const auto product = DRENCH_BY_ISA(product);
  double before[most_kept];
  std::copy_n(along_, most_kept, before);
  if (has_last_) {
    keep();
    before[slot_of(0)] = product(last_descent_.data(), residual_change_[static_cast<std::size_t>(slot_of(0))].data(), numbers);
  }
  for (int k = 0; k < kept_; ++k) {
    const int slot = slot_of(k);
    along_[slot] = product(descent_.data(), residual_change_[static_cast<std::size_t>(slot)].data(), numbers);
    if (has_last_) product_[slot_of(0)][slot] = product_[slot][slot_of(0)] = along_[slot] - before[slot];
  }
  std::swap(last_residual_, residual_);
  std::copy(shift_.begin(), shift_.end(), last_shift_.begin());
  has_last_ = true;
  Real weight[most_kept];
  const int used = weights(weight);
  const Real* change[most_kept];
  for (int k = 0; k < used; ++k) change[k] = step_change_[static_cast<std::size_t>(slot_of(k))].data();
  DRENCH_BY_ISA(combine)(shift_.data(), descent_.data(), change, weight, used, numbers);
  std::swap(last_descent_, descent_);
  std::memcpy(static_cast<void*>(shift.data()), shift_.data(), bytes);
}

/// The newest difference takes the oldest one's place.
void Differences::keep() {
  Numbers &moved = step_change_[static_cast<std::size_t>(next_)], &change = residual_change_[static_cast<std::size_t>(next_)];
  moved.resize(shift_.size());
  change.resize(shift_.size());
  for (std::size_t k = 0; k < shift_.size(); ++k) {
    moved[k] = (shift_[k] - last_shift_[k]) + (descent_[k] - last_descent_[k]);
    change[k] = residual_[k] - last_residual_[k];
  }
  kept_ = std::min(kept_ + 1, most_kept);
  next_ = (next_ + 1) % most_kept;
}

/// The weights γ of the newest differences that leave the least ‖z − Σ γ Δz‖; how many of them are told apart by more than
/// rounding.
int Differences::weights(Real* weight) const {
  constexpr double apart = 1e-6;
  double lower[most_kept][most_kept], right[most_kept];
  int used = 0;
  for (; used < kept_; ++used) {  // Cholesky, the newest first
    const int slot = slot_of(used);
    double square = product_[slot][slot];
    for (int k = 0; k < used; ++k) {
      double sum = product_[slot][slot_of(k)];
      for (int i = 0; i < k; ++i) sum -= lower[used][i] * lower[k][i];
      lower[used][k] = sum / lower[k][k];
      square -= lower[used][k] * lower[used][k];
    }
    if (!(square > apart * product_[slot][slot])) break;
    lower[used][used] = std::sqrt(square);
    double sum = along_[slot];
    for (int i = 0; i < used; ++i) sum -= lower[used][i] * right[i];
    right[used] = sum / lower[used][used];
  }
  double found[most_kept];
  for (int k = used; k-- > 0;) {
    double sum = right[k];
    for (int i = k + 1; i < used; ++i) sum -= lower[i][k] * found[i];
    found[k] = sum / lower[k][k];
    weight[k] = Real(found[k]);
  }
  return used;
}

}  // namespace drench::kokkos_backend

#endif
