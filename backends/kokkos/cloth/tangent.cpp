#include "cloth/tangent.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "cloth/limit_stiffness.hpp"
#include "cloth/membrane_stiffness.hpp"
#include "cloth/solver.hpp"

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

/// The edges by their nodes.
class EdgeNumbers {
 public:
  EdgeNumbers(const ClothSystem& s, Index nodes, Index edges) : start_(at(nodes + 1), 0), edge_(at(edges)) {
    for (Index e = 0; e < edges; ++e) ++start_[at(s.edge(2 * e) + 1)];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    std::vector<Index> next(start_.begin(), start_.end() - 1);
    for (Index e = 0; e < edges; ++e) edge_[at(next[at(s.edge(2 * e))]++)] = {s.edge(2 * e + 1), e};
  }
  /// The last edge from a to b, or −1.
  Index from(Index a, Index b) const {
    Index found = -1;
    for (Index k = start_[at(a)]; k < start_[at(a + 1)]; ++k)
      if (edge_[at(k)].end == b) found = edge_[at(k)].number;
    return found;
  }

 private:
  struct Edge {
    Index end, number;
  };
  std::vector<Index> start_;
  std::vector<Edge> edge_;
};

Matrix3 matrix(const FullBlock& k) {
  Matrix3 m;
  for (int c = 0; c < 3; ++c) m.col(c) << k.column[c].x, k.column[c].y, k.column[c].z;
  return m;
}
Matrix3 matrix(const Block& k) {
  Matrix3 m;
  m << k.xx, k.xy, k.xz, k.xy, k.yy, k.yz, k.xz, k.yz, k.zz;
  return m;
}

/// What the spring of a link resists with, N/m. One that is shorter than at rest resists along itself alone.
Block spring_stiffness(const ClothSystem& s, Index n, const Link& l, const Real3& moved_apart) {
  Block k;
  const Real3 apart = s.start(n) - s.start(l.other), x = apart + moved_apart;
  const Real square = dot(x, x);
  if (!(square > 0) && l.length == 0) k.add(l.stiffness);  // of a stitch that is closed
  if (!(l.stiffness > 0) || !(square > 0)) return k;
  const Real taut = larger(Real(0), 1 - l.length / Kokkos::sqrt(square));
  k.add(l.stiffness * taut);
  k.add(l.stiffness * (1 - taut) / square, x);
  const Real rate = s.strain_damping_rate(n);
  if (rate > 0) k.add(strain_damping(apart, l.stiffness, rate), apart);
  return k;
}

}  // namespace

ClothTangent::ClothTangent(const Cloth& cloth, const ClothSystem& s)
    : nodes_(cloth.nodes.count),
      edges_(cloth.mesh.edges),
      triangles_(s.triangle_start.exist() ? cloth.mesh.triangles : 0),
      own_(at(nodes_), Matrix3::Zero()),
      shared_(at(edges_), Matrix3::Zero()),
      bending_(at(nodes_)),
      of_triangle_(6 * at(triangles_)),
      free_(free_nodes(cloth, s)),
      row_of_(rows_of(free_, nodes_)) {
  find_edges(s, triangles_);
  list_pairs(s);
  for (Index n = 0; n < nodes_; ++n)
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) bending_[at(n)] -= s.link(l).bend;
  edge_pairs_.cholesky = BlockCholesky(pattern_of(s, false));
  if (least_growth * edge_pairs_.cholesky.work() <= most_whole_work) {
    BlockCholesky all(pattern_of(s, true));
    edge_pairs_.all = all.work() <= most_whole_work;
    if (edge_pairs_.all) edge_pairs_.cholesky = std::move(all);
  }
  const auto joined =
      static_cast<double>(std::count_if(edge_of_.begin(), edge_of_.end(), [](Index e) { return e >= 0; }));
  const double growth = double(edge_of_.size()) / std::max(1.0, joined), numbers = edge_pairs_.cholesky.numbers();
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
      if (other >= 0 && (all || edge_of_[at(l)] >= 0)) near[k].push_back(other);
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

void ClothTangent::find_edges(const ClothSystem& s, Index triangles) {
  const EdgeNumbers number(s, nodes_, edges_);
  edge_of_.assign(at(s.link_start(nodes_)), -1);
  for (Index n = 0; n < nodes_; ++n)
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Index other = s.link(l).other;
      if (const Index e = number.from(n, other); e >= 0) edge_of_[at(l)] = 2 * e;
      if (const Index e = number.from(other, n); e >= 0) edge_of_[at(l)] = 2 * e + 1;
    }
  std::vector<std::vector<EdgePart>> parts(at(edges_));
  for (Index t = 0; t < triangles; ++t)
    for (Index k = 0; k < 3; ++k) {
      const Index a = s.triangle(3 * t + k), b = s.triangle(3 * t + (k + 1) % 3);
      const std::size_t block = 6 * at(t) + 3 + at(k);
      if (const Index e = number.from(a, b); e >= 0) parts[at(e)].push_back({block, false});
      if (const Index e = number.from(b, a); e >= 0) parts[at(e)].push_back({block, true});
    }
  part_start_.assign(1, 0);
  for (const auto& p : parts) {
    parts_.insert(parts_.end(), p.begin(), p.end());
    part_start_.push_back(static_cast<Index>(parts_.size()));
  }
}

void ClothTangent::list_pairs(const ClothSystem& s) {
  pair_of_.assign(edge_of_.size(), -1);
  pair_start_.assign(1, 0);
  bending_start_.assign(1, 0);
  for (Index n = 0; n < nodes_; ++n) {
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Link link = s.link(l);
      if (edge_of_[at(l)] < 0) {
        bending_pairs_.push_back({link.other, link.bend});
        continue;
      }
      pair_of_[at(l)] = static_cast<Index>(pairs_.size());
      pairs_.push_back({link.other, edge_of_[at(l)], link.bend});
    }
    pair_start_.push_back(static_cast<Index>(pairs_.size()));
    bending_start_.push_back(static_cast<Index>(bending_pairs_.size()));
  }
  between_.assign(pairs_.size(), PairBlock::Zero());
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
      const bool held = link.other != n && (f.all || edge_of_[at(l)] >= 0);
      f.link.push_back(held ? target(n, link.other) : Target{});
      if (held) f.bending[at(n)] -= f.all ? link.bend : std::min(link.bend, Real(0));
    }
  }
}

void ClothTangent::add_triangles(const ClothSystem& s, const std::vector<Double3>& shift) {
  const Double3* const u = shift.data();
  Matrix3* const block = of_triangle_.data();
  host_parallel("drench::cloth::tangent_triangles", triangles_, [=](const Index t) {
    const auto moved = [u](const Index n) { return narrow(u[n]); };
    const CornerGradient b = corner_gradient(s.triangle_shape(t), 1), c = corner_gradient(s.triangle_shape(t), 2);
    LimitStiffness limit;
    Matrix3 first = Matrix3::Zero(), second = Matrix3::Zero(), both = Matrix3::Zero();
    if (s.limit_stiffness.exist() && limit_stiffness(s, t, moved, limit)) {
      first = matrix(limit.between(b, b));
      second = matrix(limit.between(c, c));
      both = matrix(limit.between(b, c));
    }
    if (s.membrane.exist()) {
      const MembraneStiffness membrane(s, t, moved);
      first += matrix(membrane.between(b, b));
      second += matrix(membrane.between(c, c));
      both += matrix(membrane.between(b, c));
    }
    // A triangle that moves as a whole does not resist, so the blocks of a row have the sum 0.
    Matrix3* const own = block + 6 * t;
    own[0] = (first + second) + (both + both.transpose());
    own[1] = first;
    own[2] = second;
    own[3] = -first - both.transpose();
    own[4] = both;
    own[5] = -second - both.transpose();
  });
}

void ClothTangent::update(const ClothSystem& s, const std::vector<Double3>& shift) {
  add_triangles(s, shift);
  const Double3* const u = shift.data();
  host_parallel("drench::cloth::tangent_nodes", nodes_, [=, this](const Index n) {
    if (s.pinned(n)) return;
    Matrix3 sum = s.mass(n) * s.inverse_dt2 * Matrix3::Identity();
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l)
      if (s.link(l).stiffness > 0) sum += matrix(spring_stiffness(s, n, s.link(l), narrow(u[n] - u[s.link(l).other])));
    if (triangles_ > 0)
      for (Index i = s.triangle_start(n); i < s.triangle_start(n + 1); ++i)
        sum += of_triangle_[6 * at(s.triangle_item(i) / 4) + at(s.triangle_item(i) % 4)];
    own_[at(n)] = sum;
    for (Index l = s.link_start(n); l < s.link_start(n + 1); ++l) {
      const Index e = edge_of_[at(l)];
      if (e < 0 || e % 2 == 1) continue;
      Matrix3 between = Matrix3::Zero();
      if (s.link(l).stiffness > 0)
        between -= matrix(spring_stiffness(s, n, s.link(l), narrow(u[n] - u[s.link(l).other])));
      for (Index p = part_start_[at(e / 2)]; p < part_start_[at(e / 2) + 1]; ++p) {
        const Matrix3& part = of_triangle_[parts_[at(p)].block];
        if (parts_[at(p)].transposed)
          between += part.transpose();
        else
          between += part;
      }
      shared_[at(e / 2)] = between;
    }
  });
  host_parallel("drench::cloth::tangent_pairs", static_cast<Index>(pairs_.size()), [this](const Index p) {
    const Pair pair = pairs_[at(p)];
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
  for (Index p = pair_start_[at(n)]; p < pair_start_[at(n + 1)]; ++p) {
    const Index other = pairs_[at(p)].other;
    if (group(other) == own) at_node(rho, other) -= between_[at(p)].transpose() * by;
  }
  for (Index b = bending_start_[at(n)]; b < bending_start_[at(n + 1)]; ++b) {
    const BendingPair& pair = bending_pairs_[at(b)];
    if (group(pair.other) == own) at_node(rho, pair.other) -= pair.bend * change;
  }
}

Column3 ClothTangent::from_other_groups(Index n, const NodeVector& change) const {
  const Index own = group(n);
  Column3 sum = Column3::Zero();
  for (Index p = pair_start_[at(n)]; p < pair_start_[at(n + 1)]; ++p) {
    const Index other = pairs_[at(p)].other;
    if (group(other) != own) sum += between_[at(p)].topRows<3>() * at_node(change, other);
  }
  for (Index b = bending_start_[at(n)]; b < bending_start_[at(n + 1)]; ++b) {
    const BendingPair& pair = bending_pairs_[at(b)];
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
    Column3 sum = own_[at(n)] * here + bending_[at(n)] * here;
    if (!f.all) sum += f.turning * here;
    Eigen::Matrix<Real, 4, 1> of_pairs = Eigen::Matrix<Real, 4, 1>::Zero();
    for (Index p = pair_start_[at(n)]; p < pair_start_[at(n + 1)]; ++p)
      of_pairs += between_[at(p)] * at_node(x, pairs_[at(p)].other);
    sum += of_pairs.head<3>();
    for (Index b = bending_start_[at(n)]; b < bending_start_[at(n + 1)]; ++b)
      sum += bending_pairs_[at(b)].bend * at_node(x, bending_pairs_[at(b)].other);
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
      const Index pair = pair_of_[at(l)];
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
  each([&](Index n, Eigen::Map<Column3> x) {
    at_node(z, n) = x;
    if (!freedom[at(n)].all) at_node(z, n) = (freedom[at(n)].free * x).eval();
  });
}

}  // namespace drench::kokkos_backend
