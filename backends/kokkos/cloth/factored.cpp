#include "cloth/factored.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <algorithm>
#include <cmath>
#include <limits>

namespace drench::kokkos_backend {
namespace {

double product(const Field<Real3>& a, const Field<Real3>& b) {
  double sum = 0;
  for (std::size_t n = 0; n < a.extent(0); ++n)
    sum += double(a(n).x) * double(b(n).x) + double(a(n).y) * double(b(n).y) + double(a(n).z) * double(b(n).z);
  return sum;
}

/// out = a − b.
void subtract(const Field<Real3>& a, const Field<Real3>& b, Field<Real3>& out) {
  for (std::size_t n = 0; n < out.extent(0); ++n) out(n) = a(n) - b(n);
}

void copy(const Field<Real3>& from, Field<Real3>& to) {
  std::copy_n(from.data(), to.extent(0), to.data());
}

/// The residual's forces, and their imbalance over its goal; nodes within reach of a solid are counted. `known`: the elastic
/// forces are there, for they do not depend on the target.
ThreeSums measure(const Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, double tolerance, double floor,
                  bool known, const Entries<Real3>& elastic, const Entries<Real3>& out) {
  const Entries<const Real3> shift = solver.displacement;
  const bool solids = s.solids.count > 0;
  return ordered<ThreeSums>(
      "drench::cloth::factored", cloth.nodes.count, KOKKOS_LAMBDA(const Index n) {
        if (s.pinned(n)) return ThreeSums{};
        const NodeTerms t = s.terms(n);
        if (!known) elastic(n) = s.elastic_force(n, shift);
        const Real3 r = t.inertia * (t.target - shift(n)) + elastic(n);
        out(n) = r;
        Real3 left = r;
        const double touches = solids && s.contact(t, shift(n), left).touches ? 1 : 0;
        const TwoSums sums = s.imbalance<false>(t, shift(n), r, tolerance, floor);
        return ThreeSums{sums.first, sums.second, touches};
      });
}

}  // namespace

FactoredCloth::FactoredCloth(const Cloth& cloth, const ClothSystem& system) : preconditioner_(cloth, system) {
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  for (Field<Real3>* a : {&elastic_, &residual_, &descent_, &last_shift_, &last_residual_, &last_descent_})
    allocate_zeros(*a, "drench::cloth::factored_iterate", nodes);
  for (auto* kind : {&shift_change_, &residual_change_, &descent_change_})
    for (Field<Real3>& a : *kind) allocate_zeros(a, "drench::cloth::factored_history", nodes);
}

void FactoredCloth::prepare(const Cloth& cloth, const ClothSystem& system) {
  preconditioner_.update(cloth, system);
  kept_ = next_ = 0;
  elastic_known_ = false;
  mode_ = Mode::none;
}

bool FactoredCloth::run(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& system, ClothProgress& progress,
                        int most, double tolerance, double floor) {
  const int end = progress.iterations + most;
  double smallest = std::numeric_limits<double>::max();
  has_last_ = false;  // its residual may be of another target
  for (int done = 0;; ++done) {
    const ThreeSums sums =
        measure(cloth, solver, system, tolerance, floor, elastic_known_, elastic_, residual_);
    elastic_known_ = true;
    if (sums.third > 0) return false;
    progress.residual = over_goal({sums.first, sums.second});
    if ((progress.residual <= 1 && done > 0) || progress.iterations >= end) return true;
    if (!(progress.residual <= most_growth * smallest)) {
      kept_ = next_ = 0;
      if (mode_ != Mode::safe && has_last_) {  // back to where it was led astray from
        mode_ = mode_ == Mode::begun ? Mode::again : Mode::safe;
        copy(last_shift_, solver.displacement);
        if (mode_ == Mode::again) preconditioner_.update_across(cloth, system, solver.displacement);
        has_last_ = elastic_known_ = false;
        continue;
      }
    }
    if (mode_ == Mode::none) {
      preconditioner_.update_across(cloth, system, solver.displacement);
      mode_ = Mode::begun;
    }
    smallest = std::min(smallest, progress.residual);
    step(solver);
    elastic_known_ = false;
    ++progress.iterations;
  }
}

void FactoredCloth::step(ClothSolverWork& solver) {
  Field<Real3>& shift = solver.displacement;
  const std::size_t nodes = shift.extent(0);
  preconditioner_.apply(std::as_const(residual_), descent_, mode_ == Mode::safe);
  if (has_last_) keep_difference(solver);
  copy(shift, last_shift_);
  copy(residual_, last_residual_);
  copy(descent_, last_descent_);
  has_last_ = true;
  double weight[most_kept];
  const int used = weights(weight);
  for (std::size_t n = 0; n < nodes; ++n) {
    Real3 next = shift(n) + descent_(n);
    for (int k = 0; k < used; ++k) {
      const int slot = (next_ - 1 - k + most_kept) % most_kept;
      next -= Real(weight[k]) * (shift_change_[slot](n) + descent_change_[slot](n));
    }
    shift(n) = next;
  }
}

void FactoredCloth::keep_difference(const ClothSolverWork& solver) {
  const int slot = next_;
  subtract(solver.displacement, last_shift_, shift_change_[slot]);
  subtract(residual_, last_residual_, residual_change_[slot]);
  subtract(descent_, last_descent_, descent_change_[slot]);
  kept_ = std::min(kept_ + 1, most_kept);
  next_ = (slot + 1) % most_kept;
  for (int k = 0; k < kept_; ++k) {
    const int other = (slot - k + most_kept) % most_kept;
    product_[slot][other] = product_[other][slot] = product(descent_change_[slot], residual_change_[other]);
  }
}

/// The weights γ of the newest differences that leave the least ‖z − Σ γ Δz‖ in the norm of A; how many of them are told
/// apart by more than rounding.
int FactoredCloth::weights(double* weight) const {
  constexpr double apart = 1e-6;
  double lower[most_kept][most_kept], right[most_kept];
  int used = 0;
  for (; used < kept_; ++used) {  // Cholesky, the newest first
    const int slot = (next_ - 1 - used + most_kept) % most_kept;
    double square = product_[slot][slot];
    for (int k = 0; k < used; ++k) {
      const int other = (next_ - 1 - k + most_kept) % most_kept;
      double sum = product_[slot][other];
      for (int i = 0; i < k; ++i) sum -= lower[used][i] * lower[k][i];
      lower[used][k] = sum / lower[k][k];
      square -= lower[used][k] * lower[used][k];
    }
    if (!(square > apart * product_[slot][slot])) break;
    lower[used][used] = std::sqrt(square);
    double sum = product(residual_change_[slot], descent_);
    for (int i = 0; i < used; ++i) sum -= lower[used][i] * right[i];
    right[used] = sum / lower[used][used];
  }
  for (int k = used; k-- > 0;) {
    double sum = right[k];
    for (int i = k + 1; i < used; ++i) sum -= lower[i][k] * weight[i];
    weight[k] = sum / lower[k][k];
  }
  return used;
}

bool prepare_factored_cloth(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s) {
  if (!solver.factored) solver.factored = std::make_shared<FactoredCloth>(cloth, s);
  solver.factored->prepare(cloth, s);
  return true;
}

bool run_factored_cloth(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& s, ClothProgress& progress, int most,
                        double tolerance, double floor) {
  return solver.factored->run(cloth, solver, s, progress, most, tolerance, floor);
}

}  // namespace drench::kokkos_backend

#else

namespace drench::kokkos_backend {

bool prepare_factored_cloth(const Cloth&, ClothSolverWork&, const ClothSystem&) { return false; }
bool run_factored_cloth(const Cloth&, ClothSolverWork&, const ClothSystem&, ClothProgress&, int, double, double) {
  return false;
}

}  // namespace drench::kokkos_backend

#endif
