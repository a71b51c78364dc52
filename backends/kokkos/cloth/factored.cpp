#include "cloth/factored.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <algorithm>
#include <limits>

namespace drench::kokkos_backend {
namespace {

constexpr Index chunk = 64;        // nodes whose sums are added one after the other
constexpr double most_work = 1e9;  // multiplications of a factorisation that pay, some 30 ms

}  // namespace

FactoredCloth::FactoredCloth(const Cloth& cloth, const ClothSystem& system)
    : hessian_(cloth, system, most_work), differences_(cloth.nodes.count) {
  const auto nodes = static_cast<std::size_t>(cloth.nodes.count);
  for (Field<Real3>* a : {&elastic_, &residual_, &descent_}) allocate_zeros(*a, "drench::cloth::factored_iterate", nodes);
  parts_.resize((nodes + chunk - 1) / chunk);
}

void FactoredCloth::prepare(const Cloth& cloth, const ClothSystem& system) {
  elastic_known_ = false;
  if (placed_ == cloth.moved && dt_ == system.dt) return;
  placed_ = cloth.moved;
  dt_ = system.dt;
  differences_.clear();
  mode_ = Mode::none;
}

ThreeSums FactoredCloth::measure(const Cloth& cloth, const ClothSolverWork& solver, const ClothSystem& s, double tolerance,
                                 double floor) {
  const Entries<const Real3> shift = solver.displacement;
  const Entries<Real3> elastic = elastic_, residual = residual_;
  const bool solids = s.solids.count > 0, known = elastic_known_;
  const Index nodes = cloth.nodes.count;
  ThreeSums* const part = parts_.data();
  parallel("drench::cloth::factored", static_cast<Index>(parts_.size()), [=](const Index p) {
    ThreeSums sum;
    for (Index n = p * chunk; n < std::min(nodes, (p + 1) * chunk); ++n) {
      if (s.pinned(n)) continue;
      const NodeTerms t = s.terms(n);
      if (!known) elastic(n) = s.elastic_force(n, shift);
      const Real3 r = t.inertia * (t.target - shift(n)) + elastic(n);
      residual(n) = r;
      Real3 left = r;
      const double touches = solids && s.contact(t, shift(n), left, t.compression).touches ? 1 : 0;
      const TwoSums sums = s.imbalance<false>(t, shift(n), r, tolerance, floor);
      sum += ThreeSums{sums.first, sums.second, touches};
    }
    part[p] = sum;
  });
  ThreeSums all;
  for (const ThreeSums& p : parts_) all += p;
  elastic_known_ = true;
  return all;
}

bool FactoredCloth::run(const Cloth& cloth, ClothSolverWork& solver, const ClothSystem& system, ClothProgress& progress,
                        int most, double tolerance, double floor) {
  const int end = progress.iterations + most;
  double smallest = std::numeric_limits<double>::max();
  differences_.part();
  for (int done = 0;; ++done) {
    const ThreeSums sums = measure(cloth, solver, system, tolerance, floor);
    if (sums.third > 0) return false;
    progress.residual = over_goal({sums.first, sums.second});
    if ((progress.residual <= 1 && done > 0) || progress.iterations >= end) return true;
    const bool astray = !(progress.residual <= most_growth * std::max(smallest, 1.0));
    if (astray && mode_ != Mode::safe && differences_.has_last()) {
      differences_.copy_last(solver.displacement);
      if (mode_ == Mode::begun) {
        factor(cloth, system, solver.displacement);
        mode_ = Mode::again;
      } else {
        make_safe(cloth, system);
      }
      elastic_known_ = false;
      continue;
    }
    if (astray) differences_.clear();
    if (mode_ == Mode::none) {
      factor(cloth, system, solver.displacement);
      mode_ = Mode::begun;
    }
    smallest = std::min(smallest, progress.residual);
    if (mode_ != Mode::safe && hessian_.exists())
      hessian_.apply(std::as_const(residual_), descent_);
    else
      projective_->apply(std::as_const(residual_), descent_, mode_ == Mode::safe);
    differences_.step(solver.displacement, residual_, descent_);
    elastic_known_ = false;
    ++progress.iterations;
  }
}

void FactoredCloth::factor(const Cloth& cloth, const ClothSystem& system, const Entries<const Real3>& shift) {
  differences_.clear();
  if (hessian_.exists()) return hessian_.update(cloth, system, shift);
  projective(cloth, system).update(cloth, system);
  projective_->update_across(cloth, system, shift);
}

void FactoredCloth::make_safe(const Cloth& cloth, const ClothSystem& system) {
  differences_.clear();
  projective(cloth, system).update(cloth, system);
  mode_ = Mode::safe;
}

PdPreconditioner& FactoredCloth::projective(const Cloth& cloth, const ClothSystem& system) {
  if (!projective_) projective_ = std::make_unique<PdPreconditioner>(cloth, system);
  return *projective_;
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
