// The factor of the cloth's Hessian on a host against Eigen's, on graphs of one to eight leaves of a dissection.

#include <gtest/gtest.h>

#include "core/types.hpp"

#ifndef KOKKOS_ENABLE_CUDA

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "cloth/block_cholesky.hpp"

namespace drench::test {
namespace {

using kokkos_backend::BlockCholesky;
using kokkos_backend::NodeGraph;
using kokkos_backend::Real;

/// A grid whose nodes share entries with all that are up to two lines away; `holes`: some are missing.
NodeGraph grid(Index width, Index height, bool holes) {
  std::vector<Index> number(at(width * height), -1);
  std::mt19937 random(7);
  Index count = 0;
  for (Index& n : number) n = holes && random() % 5 == 0 ? -1 : count++;
  NodeGraph near(at(count));
  for (Index y = 0; y < height; ++y)
    for (Index x = 0; x < width; ++x)
      for (Index v = std::max(0, y - 2); v < std::min(height, y + 3); ++v)
        for (Index u = std::max(0, x - 2); u < std::min(width, x + 3); ++u) {
          const Index own = number[at(y * width + x)], other = number[at(v * width + u)];
          if (own >= 0 && other >= 0 && own != other) near[at(own)].push_back(other);
        }
  return near;
}

/// Largest |x − x*| over the largest |x*| of H x = b with a matrix of random symmetric blocks, diagonally dominant.
double error_of_solution(const NodeGraph& near) {
  BlockCholesky factor(near);
  factor.make_room();
  factor.clear();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Eigen::Triplet<double>> entries;
  const auto set = [&](Index i, Index j, const Eigen::Matrix3d& block) {
    const BlockCholesky::Place place = factor.is_below(i, j) ? factor.block(i, j) : factor.block(j, i);
    for (Index r = 0; r < 3; ++r)
      for (Index c = 0; c < 3; ++c) {
        factor.values()[place.at + at(c * place.stride + r)] = Real(block(r, c));
        entries.emplace_back(3 * i + r, 3 * j + c, double(Real(block(r, c))));
        if (i != j) entries.emplace_back(3 * j + r, 3 * i + c, double(Real(block(r, c))));
      }
  };
  const auto random_block = [&] {
    const Eigen::Matrix3d any = Eigen::Matrix3d::NullaryExpr([&] { return number(random); });
    return Eigen::Matrix3d(0.5 * (any + any.transpose()));
  };
  const auto size = static_cast<Index>(near.size());
  Eigen::VectorXd b(3 * size);
  for (Index i = 0; i < size; ++i) {
    set(i, i, random_block() + (3.0 * double(near[at(i)].size()) + 4) * Eigen::Matrix3d::Identity());
    for (const Index j : near[at(i)])
      if (j < i) set(i, j, random_block());
    for (Index a = 0; a < 3; ++a) b(3 * i + a) = number(random);
  }
  Eigen::SparseMatrix<double> h(3 * size, 3 * size);
  h.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd expected = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(h).solve(b);
  std::vector<Real> x(3 * at(size));
  for (Index i = 0; i < size; ++i)
    for (Index a = 0; a < 3; ++a) x[at(3 * factor.place(i) + a)] = Real(b(3 * i + a));
  factor.factor();
  factor.solve(x.data());
  double error = 0;
  for (Index i = 0; i < size; ++i)
    for (Index a = 0; a < 3; ++a)
      error = std::max(error, std::abs(double(x[at(3 * factor.place(i) + a)]) - expected(3 * i + a)));
  return error / expected.cwiseAbs().maxCoeff();
}

}  // namespace

TEST(block_cholesky, solves_as_eigen_does) {
  const double bound = sizeof(Real) == 4 ? 2e-5 : 1e-13;
  EXPECT_LE(error_of_solution(grid(1, 1, false)), bound);
  EXPECT_LE(error_of_solution(grid(7, 3, false)), bound);
  EXPECT_LE(error_of_solution(grid(25, 20, false)), bound) << "two leaves";
  EXPECT_LE(error_of_solution(grid(40, 11, true)), bound) << "pieces that hang together loosely";
  EXPECT_LE(error_of_solution(grid(100, 61, false)), bound) << "eight leaves";
}

TEST(block_cholesky, parts_share_no_entry) {
  for (const NodeGraph& near : {grid(30, 30, false), grid(100, 61, false), grid(60, 20, true)}) {
    const kokkos_backend::Dissection d = kokkos_backend::dissect(near);
    EXPECT_GT(d.levels, 0);
    std::vector<std::size_t> size(at(d.parts()));
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Index own = d.part[i];
      ++size[at(own)];
      for (const Index j : near[i]) {
        const Index other = d.part[at(j)];
        EXPECT_TRUE(own == other || d.is_below(own, other) || d.is_below(other, own)) << own << " and " << other;
      }
    }
    const Index leaves = d.first_part(1);
    for (Index p = 0; p < leaves; ++p) EXPECT_GT(size[at(p)], near.size() / at(3 * leaves)) << "of leaf " << p;
    EXPECT_LT(std::accumulate(size.begin() + leaves, size.end(), std::size_t{0}), near.size() / 3) << "separators";
    EXPECT_EQ(std::set<Index>(d.place.begin(), d.place.end()).size(), near.size());
  }
}

}  // namespace drench::test

#endif
