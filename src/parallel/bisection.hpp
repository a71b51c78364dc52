#pragma once
// Space cut in two along the longest axis of the points in it, and its parts again, down to a part for each rank:
// orthogonal recursive bisection (Berger and Bokhari 1987).

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace drench {

inline constexpr std::int64_t points_of_rank = 8192;  ///< that a cut looks at
inline constexpr double most_imbalance = 1.1;         ///< of the fullest rank over the mean, before space is cut anew

/// A point with what it counts.
struct WeightedPoint {
  std::array<double, 3> at{};
  double weight = 0;
};

/// A rank's part: min ≤ x < max on each axis, with infinite sides.
struct RankPart {
  std::array<double, 3> min{-INFINITY, -INFINITY, -INFINITY}, max{INFINITY, INFINITY, INFINITY};
};

class Bisection {
 public:
  /// Parts of about the same weight; points that are no numbers count nowhere. A part without points gives all of its
  /// space to its first rank.
  Bisection(std::vector<WeightedPoint> points, int ranks);

  const std::vector<RankPart>& parts() const { return parts_; }
  int rank_of(const std::array<double, 3>& x) const;
  /// Calls visit(rank) for each rank whose part is within `reach` of x on every axis.
  template <class Visit>
  void near(const std::array<double, 3>& x, double reach, const Visit& visit) const {
    descend(0, x, reach, visit);
  }

 private:
  struct Cut {
    std::size_t axis = 0;
    double at = 0;
    std::size_t above = 0;  // where the cuts of the upper part begin; the lower part's follow this one
    int rank = -1;          // 0 and above: no cut, but this rank
  };
  using Points = std::vector<WeightedPoint>::iterator;

  void cut(Points first, Points last, int first_rank, int ranks, const RankPart& space);

  template <class Visit>
  void descend(std::size_t k, const std::array<double, 3>& x, double reach, const Visit& visit) const {
    const Cut& c = cuts_[k];
    if (c.rank >= 0) return visit(c.rank);
    if (x[c.axis] - c.at < reach) descend(k + 1, x, reach, visit);
    if (x[c.axis] - c.at > -reach) descend(c.above, x, reach, visit);
  }

  std::vector<Cut> cuts_;
  std::vector<RankPart> parts_;
};

}  // namespace drench
