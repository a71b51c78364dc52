#include "parallel/bisection.hpp"

#include <algorithm>

namespace drench {
namespace {

using Points = std::vector<WeightedPoint>::iterator;

constexpr std::size_t most_points = 1 << 20;  // a thousand of each of a thousand ranks; more would take seconds

/// Every so many-th point stands for those behind it.
void thin_out(std::vector<WeightedPoint>& points) {
  const std::size_t stride = (points.size() + most_points - 1) / most_points;
  if (stride <= 1) return;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k % stride == 0)
      points[kept++] = points[k];
    else
      points[kept - 1].weight += points[k].weight;
  }
  points.resize(kept);
}

double weight_of(Points first, Points last) {
  double sum = 0;
  for (Points p = first; p != last; ++p) sum += p->weight;
  return sum;
}

std::size_t longest_axis(Points first, Points last) {
  std::size_t axis = 0;
  double longest = -1;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto [least, most] =
        std::minmax_element(first, last, [a](const auto& p, const auto& q) { return p.at[a] < q.at[a]; });
    if (most->at[a] - least->at[a] <= longest) continue;
    longest = most->at[a] - least->at[a];
    axis = a;
  }
  return axis;
}

/// The coordinate up to which so much weight lies, by halving what is left.
double median(Points first, Points last, std::size_t axis, double wanted) {
  while (last - first > 1) {
    const Points middle = first + (last - first) / 2;
    std::nth_element(first, middle, last, [axis](const auto& p, const auto& q) { return p.at[axis] < q.at[axis]; });
    const double left = weight_of(first, middle);
    if (left < wanted) {
      wanted -= left;
      first = middle;
    } else {
      last = middle;
    }
  }
  return first->at[axis];
}

/// Orders the points into two parts, the lower with about `share` of the weight, and returns where the upper one
/// begins. Points in a plane stay together, on the side where the parts come closer to that.
Points upper_part(Points first, Points last, std::size_t axis, double share) {
  const double wanted = share * weight_of(first, last), at = median(first, last, axis, wanted);
  const Points plane = std::partition(first, last, [=](const auto&p) { return p.at[axis] < at; }),
               behind = std::partition(plane, last, [=](const auto&p) { return p.at[axis] <= at; });
  if (behind == last) return plane;
  const double under = weight_of(first, plane), over = under + weight_of(plane, behind);
  return plane == first || over - wanted < wanted - under ? behind : plane;
}

}  // namespace

Bisection::Bisection(std::vector<WeightedPoint> points, int ranks) : parts_(static_cast<std::size_t>(ranks)) {
  std::erase_if(points, [](const WeightedPoint& p) {
    return !std::isfinite(p.at[0]) || !std::isfinite(p.at[1]) || !std::isfinite(p.at[2]);
  });
  thin_out(points);
  cuts_.reserve(2 * static_cast<std::size_t>(ranks));
  cut(points.begin(), points.end(), 0, ranks, RankPart{});
}

void Bisection::cut(Points first, Points last, int first_rank, int ranks, const RankPart& space) {
  const std::size_t here = cuts_.size();
  cuts_.emplace_back();
  if (ranks == 1 || first == last) {
    cuts_[here].rank = first_rank;
    const auto part = parts_.begin() + first_rank;
    const double none = INFINITY;
    std::fill(part, part + ranks, RankPart{{none, none, none}, {-none, -none, -none}});
    *part = space;
    return;
  }
  const std::size_t axis = longest_axis(first, last);
  const int left = ranks / 2;
  const Points upper = upper_part(first, last, axis, static_cast<double>(left) / ranks);
  const double at =
      std::min_element(upper, last, [axis](const auto& p, const auto& q) { return p.at[axis] < q.at[axis]; })->at[axis];
  RankPart below = space, above = space;
  below.max[axis] = above.min[axis] = at;
  cuts_[here].axis = axis;
  cuts_[here].at = at;
  cut(first, upper, first_rank, left, below);
  cuts_[here].above = cuts_.size();
  cut(upper, last, first_rank + left, ranks - left, above);
}

int Bisection::rank_of(const std::array<double, 3>& x) const {
  std::size_t k = 0;
  while (cuts_[k].rank < 0) k = x[cuts_[k].axis] < cuts_[k].at ? k + 1 : cuts_[k].above;
  return cuts_[k].rank;
}

}  // namespace drench
