#include "cloth/anderson.hpp"

#include <Eigen/QR>

namespace drench::kokkos_backend {
namespace {

constexpr double most_weight = 100;  // of a step that is trusted

/// A vector at the end of `list`: a new one, or the oldest where there are `most`.
NodeVector& next_of(std::vector<NodeVector>& list, std::size_t most, std::size_t length) {
  if (list.size() < most)
    list.emplace_back(length);
  else
    std::rotate(list.begin(), list.begin() + 1, list.end());
  return list.back();
}

}  // namespace

void AndersonAcceleration::clear() {
  has_last_ = false;
  along_.clear();
  step_change_.clear();
  left_change_.clear();
}

void AndersonAcceleration::keep_differences(const std::vector<Double3>& shift, const NodeVector& left,
                                            const NodeVector& step) {
  const std::size_t length = step.size();
  NodeVector &along = next_of(along_, most_kept, length), &step_change = next_of(step_change_, most_kept, length),
             &left_change = next_of(left_change_, most_kept, length);
  host_parallel("drench::cloth::anderson_differences", nodes_, [&](const Index n) {
    const auto k = static_cast<std::size_t>(n);
    at_node(step_change, n) = at_node(step, n) - at_node(last_step_, n);
    at_node(along, n) = column(shift[k] - last_shift_[k]) + at_node(step_change, n);
    at_node(left_change, n) = at_node(left, n) - at_node(last_left_, n);
  });
}

bool AndersonAcceleration::combine(const std::vector<Double3>& shift, const NodeVector& left, NodeVector& step) {
  if (has_last_) keep_differences(shift, left, step);
  has_last_ = true;
  last_shift_ = shift;
  last_left_ = left;
  last_step_ = step;
  const std::size_t kept = along_.size();
  if (kept == 0) return false;
  Eigen::MatrixXd product(kept, kept);
  Eigen::VectorXd with(kept);
  for (std::size_t i = 0; i < kept; ++i) {
    for (std::size_t j = 0; j < kept; ++j)
      product(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = sums_.dot(step_change_[j], left_change_[i]);
    with[static_cast<Eigen::Index>(i)] = sums_.dot(step, left_change_[i]);
  }
  const Eigen::VectorXd weight = product.colPivHouseholderQr().solve(with);
  if (!weight.allFinite() || weight.cwiseAbs().maxCoeff() > most_weight) return false;
  for (std::size_t i = 0; i < kept; ++i)
    add_scaled("drench::cloth::anderson_combine", Real(-weight[static_cast<Eigen::Index>(i)]), along_[i], step);
  return true;
}

}  // namespace drench::kokkos_backend
