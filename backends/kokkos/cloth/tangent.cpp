#include "cloth/tangent.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "cloth/tangent_blocks.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Real negligible = Real(1e-10);  // of the largest entry of a block
constexpr double most_whole_work = 1e8;   // multiplications for which the factor holds all pairs that bend, some 3 ms
constexpr double least_growth = 4;      // of the multiplications with all pairs: 8 to 30 times those of the edges alone
constexpr double most_numbers = 2.5e8;  // of a factor with all pairs: about 1 GB in single precision
constexpr double work_per_iteration = 50;  // multiplications of a factor, per number of the factor of the edges, in
                                           // the time of a linear iteration

std::vector<Index> free_nodes(const Cloth& cloth, const ClothSystem& s) {
  std::vector<Index> free;
  for (Index n = 0; n < cloth.nodes.count; ++n)
    if (!s.pinned(n)) free.push_back(n);
  return free;
}
std::vector<Index> rows_of(const std::vector<Index>& free, Index nodes) {
  std::vector<Index> row(static_cast<std::size_t>(nodes), -1);
  for (std::size_t k = 0; k < free.size(); ++k) row[static_cast<std::size_t>(free[k])] = static_cast<Index>(k);
  return row;
}

}  // namespace

ClothTangent::ClothTangent(const Cloth& cloth, const ClothSystem& s)
    : nodes_(cloth.nodes.count),
      edges_(cloth.mesh.edges),
      triangles_(s.triangle_start.exist() ? cloth.mesh.triangles : 0),
      pattern_(s, nodes_, edges_, triangles_),
      between_(pattern_.pairs.size(), PairBlock::Zero()),
      own_(at(nodes_), Matrix3::Zero()),
      shared_(at(edges_), Matrix3::Zero()),
      of_triangle_(6 * at(triangles_)),
      free_(free_nodes(cloth, s)),
      row_of_(rows_of(free_, nodes_)) {
  edge_pairs_.cholesky = BlockCholesky(pattern_of(s, false));
  if (least_growth * edge_pairs_.cholesky.work() <= most_whole_work) {
    BlockCholesky all(pattern_of(s, true));
    edge_pairs_.all = all.work() <= most_whole_work;
    if (edge_pairs_.all) edge_pairs_.cholesky = std::move(all);
  }
  const auto joined = static_cast<double>(
      std::count_if(pattern_.edge_of.begin(), pattern_.edge_of.end(), [](Index e) { return e >= 0; }));
  const double growth = double(pattern_.edge_of.size()) / std::max(1.0, joined),
               numbers = edge_pairs_.cholesky.numbers();
  cost_of_all_ = numbers * growth * growth > most_numbers
                     ? std::numeric_limits<double>::infinity()
                     : edge_pairs_.cholesky.work() * growth * growth * growth / (work_per_iteration * numbers);
  make_room(s, edge_pairs_);
  group_.assign(at(nodes_), -1);
  for (std::size_t k = 0; k < free_.size(); ++k)
    group_[at(free_[k])] = edge_pairs_.cholesky.part(static_cast<Index>(k));
  solution_.resize(3 * free_.size());
}

/// The free nodes that share an edge, or any link (`all`).
NodeGraph ClothTangent::pattern_of(const ClothSystem& s, bool all) const {
  NodeGraph near(free_.size());
  for (std::size_t k = 0; k < free_.size(); ++k)
    for (Index l = s.link_start(free_[k]); l < s.link_start(free_[k] + 1); ++l) {
      const Index other = row_of_[at(s.link(l).other)];
      if (other >= 0 && (all || pattern_.edge_of[at(l)] >= 0)) near[k].push_back(other);
    }
  return near;
}

void ClothTangent::hold_all(const ClothSystem& s) {
  if (!all_pairs_) {
    all_pairs_ = std::make_unique<Factor>();
    all_pairs_->cholesky = BlockCholesky(pattern_of(s, true));
    all_pairs_->all = true;
    if (all_pairs_->cholesky.numbers() > most_numbers) {
      all_pairs_.reset();
      cost_of_all_ = std::numeric_limits<double>::infinity();
      return;
    }
    make_room(s, *all_pairs_);
  }
  held_ = all_pairs_.get();
}

void ClothTangent::make_room(const ClothSystem& s, Factor& f) const {
  f.cholesky.make_room();
  f.bending.resize(at(nodes_));
  const auto target = [&](Index n, Index m) -> Target {
    const Index i = row_of_[at(n)], j = row_of_[at(m)];
    if (i < 0 || j < 0 || !f.cholesky.is_below(i, j)) return {};
    const BlockCholesky::Place place = f.cholesky.block(i, j);
    return {static_cast<std::uint32_t>(place.at), place.stride};
  };
  for (Index n = 0; n < nodes_; ++n) {
    f.own.push_back(target(n, n));
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Link link = s.link(l);
      // Terms of a grid's bending hold a node twice: such a link with itself cancels out.
      const bool held = link.other != n && (f.all || pattern_.edge_of[at(l)] >= 0);
      f.link.push_back(held ? target(n, link.other) : Target{});
      if (held) f.bending[at(n)] -= f.all ? link.bend : std::min(link.bend, Real(0));
    }
  }
}

void ClothTangent::update(const ClothSystem& s, const std::vector<Double3>& shift) {
  const Double3* const u = shift.data();
  Matrix3* const of_triangle = of_triangle_.data();
  host_parallel("drench::cloth::tangent_triangles", triangles_,
                [=](const Index t) { triangle_blocks(s, t, u, of_triangle + 6 * t); });
  host_parallel("drench::cloth::tangent_nodes", nodes_, [=, this](const Index n) {
    if (s.pinned(n)) return;
    own_[at(n)] = own_block(s, n, u, of_triangle);
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Index e = pattern_.edge_of[at(l)];
      if (e < 0 || e % 2 == 1) continue;
      const EdgePart* const part = pattern_.parts.data();
      const Index first = pattern_.part_start[at(e / 2)], end = pattern_.part_start[at(e / 2) + 1];
      shared_[at(e / 2)] = edge_block(s, n, s.link(l), part + first, part + end, u, of_triangle, false);
    }
  });
  host_parallel("drench::cloth::tangent_pairs", static_cast<Index>(pattern_.pairs.size()), [this](const Index p) {
    const TangentPair pair = pattern_.pairs[at(p)];
    const Matrix3& shared = shared_[at(pair.edge / 2)];
    auto block = between_[at(p)].topRows<3>();
    if (pair.edge % 2 == 0)
      block = shared;
    else
      block = shared.transpose();
    block.diagonal().array() += pair.bend;
  });
}

void ClothTangent::subtract_change(Index n, const Column3& change, NodeVector& rho) const {
  const Eigen::Matrix<Real, 4, 1> by(change[0], change[1], change[2], 0);
  const Index own = group(n);
  for (Index p = pattern_.pair_start[at(n)]; p < pattern_.pair_start[at(n + 1)]; ++p) {
    const Index other = pattern_.pairs[at(p)].other;
    if (group(other) == own) at_node(rho, other) -= between_[at(p)].transpose() * by;
  }
  for (Index b = pattern_.bending_start[at(n)]; b < pattern_.bending_start[at(n + 1)]; ++b) {
    const BendingPair& pair = pattern_.bending_pairs[at(b)];
    if (group(pair.other) == own) at_node(rho, pair.other) -= pair.bend * change;
  }
}

Column3 ClothTangent::from_other_groups(Index n, const NodeVector& change) const {
  const Index own = group(n);
  Column3 sum = Column3::Zero();
  for (Index p = pattern_.pair_start[at(n)]; p < pattern_.pair_start[at(n + 1)]; ++p) {
    const Index other = pattern_.pairs[at(p)].other;
    if (group(other) != own) sum += between_[at(p)].topRows<3>() * at_node(change, other);
  }
  for (Index b = pattern_.bending_start[at(n)]; b < pattern_.bending_start[at(n + 1)]; ++b) {
    const BendingPair& pair = pattern_.bending_pairs[at(b)];
    if (group(pair.other) != own) sum += pair.bend * at_node(change, pair.other);
  }
  return sum;
}

void ClothTangent::multiply(const ClothSystem& s, const std::vector<NodeFreedom>& freedom, bool contact_rows,
                            const NodeVector& x, NodeVector& y) const {
  host_parallel("drench::cloth::tangent_times", nodes_, [&, this](const Index n) {
    if (s.pinned(n)) {
      at_node(y, n).setZero();
      return;
    }
    const NodeFreedom& f = freedom[at(n)];
    const Column3 here = at_node(x, n);
    Column3 sum = own_[at(n)] * here + pattern_.bending[at(n)] * here;
    if (!f.all) sum += f.turning * here;
    Eigen::Matrix<Real, 4, 1> of_pairs = Eigen::Matrix<Real, 4, 1>::Zero();
    for (Index p = pattern_.pair_start[at(n)]; p < pattern_.pair_start[at(n + 1)]; ++p)
      of_pairs += between_[at(p)] * at_node(x, pattern_.pairs[at(p)].other);
    sum += of_pairs.head<3>();
    for (Index b = pattern_.bending_start[at(n)]; b < pattern_.bending_start[at(n + 1)]; ++b)
      sum += pattern_.bending_pairs[at(b)].bend * at_node(x, pattern_.bending_pairs[at(b)].other);
    if (contact_rows && !f.all) sum = (f.free * sum + f.normal.dot(sum) * f.drag).eval();
    at_node(y, n) = sum;
  });
}

void ClothTangent::factor(const ClothSystem& s, const std::vector<NodeFreedom>& freedom) {
  Factor& factor = *held_;
  factor.cholesky.clear();
  Real* const values = factor.cholesky.values();
  // Entries that rounding alone makes of a plane sheet would lead to subnormal numbers, with which a factor takes ten
  // times as long.
  const auto put = [values](const Target& to, const Matrix3& k) {
    const Real least = negligible * k.cwiseAbs().maxCoeff();
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        values[to.at + at(c) * at(to.stride) + at(r)] = std::abs(k(r, c)) > least ? k(r, c) : Real(0);
  };
  host_parallel("drench::cloth::tangent_factor", nodes_, [&, this](const Index n) {
    if (row_of_[at(n)] < 0) return;
    const NodeFreedom& f = freedom[at(n)];
    Matrix3 k = own_[at(n)] + factor.bending[at(n)] * Matrix3::Identity();
    if (!f.all) {
      k += f.turning;
      const Real mean = k.trace() / 3;
      k = (f.free * k * f.free + mean * (Matrix3::Identity() - f.free)).eval();
    }
    put(factor.own[at(n)], k);
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      if (factor.link[at(l)].stride == 0) continue;
      const Link link = s.link(l);
      const Index pair = pattern_.pair_of[at(l)];
      Matrix3 between = link.bend * Matrix3::Identity();
      if (pair >= 0) between = between_[at(pair)].topRows<3>();
      if (!factor.all) between.diagonal().array() -= std::max(link.bend, Real(0));
      if (!f.all) between = (f.free * between).eval();
      const NodeFreedom& other = freedom[at(link.other)];
      if (!other.all) between = (between * other.free).eval();
      put(factor.link[at(l)], between);
    }
  });
  factor.cholesky.factor();
}

void ClothTangent::precondition(const std::vector<NodeFreedom>& freedom, const NodeVector& r, NodeVector& z) {
  const auto each = [this](const auto& act) {
    host_parallel("drench::cloth::tangent_place", static_cast<Index>(free_.size()), [&, this](const Index k) {
      act(free_[at(k)], Eigen::Map<Column3>(solution_.data() + 3 * held_->cholesky.place(k)));
    });
  };
  each([&](Index n, Eigen::Map<Column3> x) {
    x = at_node(r, n);
    if (!freedom[at(n)].all) x = (freedom[at(n)].free * x).eval();
  });
  held_->cholesky.solve(solution_.data());
  each([&](Index n, const Eigen::Map<Column3>& x) {
    at_node(z, n) = x;
    if (!freedom[at(n)].all) at_node(z, n) = (freedom[at(n)].free * x).eval();
  });
}

}  // namespace drench::kokkos_backend
