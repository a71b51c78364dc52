#pragma once
// Sums and maxima over all ranks of a run; one rank alone has them already.

#include <cstdint>
#include <vector>

#include "core/exact_sum.hpp"
#include "parallel/communicator.hpp"

namespace drench::kokkos_backend {

/// Collects numbers, and puts in their place what all ranks have: one message for all of them.
class OverRanks {
 public:
  explicit OverRanks(const Communicator* ranks) : ranks_(ranks) {}
  OverRanks& sum(std::int64_t& number) {
    if (ranks_) sums_.push_back(&number);
    return *this;
  }
  OverRanks& sum(ExactSum& number) { return sum(number.high).sum(number.low); }
  OverRanks& maximum(double& number) {
    if (ranks_) maxima_.push_back(&number);
    return *this;
  }
  void reduce() {
    if (!ranks_) return;
    std::vector<std::int64_t> sums;
    std::vector<double> maxima;
    for (const auto* number : sums_) sums.push_back(*number);
    for (const auto* number : maxima_) maxima.push_back(*number);
    ranks_->all_reduce(sums, maxima);
    for (std::size_t k = 0; k < sums.size(); ++k) *sums_[k] = sums[k];
    for (std::size_t k = 0; k < maxima.size(); ++k) *maxima_[k] = maxima[k];
  }

 private:
  const Communicator* ranks_;
  std::vector<std::int64_t*> sums_;
  std::vector<double*> maxima_;
};

/// The sums of all ranks, of a kind that hands its numbers to visit(OverRanks&).
template <class Sums>
Sums over_ranks(const Communicator* ranks, Sums own) {
  OverRanks all(ranks);
  own.visit(all);
  all.reduce();
  return own;
}

}  // namespace drench::kokkos_backend
