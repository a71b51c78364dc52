#include "setup/rank_share.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "parallel/bisection.hpp"

namespace drench {
namespace {

bool finite(const Vec3& x) { return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]); }

}  // namespace

double RankShare::ghosts(double particles) const {
  const double own = part * particles;
  return std::min(std::pow(std::cbrt(own) + layer, 3) - own, std::max(0.0, particles - own));
}

RankShare expected_share(int ranks, double reach) {
  if (ranks == 1) return {};
  const double faces = std::min(6.0, std::ceil(std::log2(ranks)));
  const double layers = reach + 0.5;  // where particles lie in planes, a cut lies on one
  return {ranks, std::min(1.0, most_imbalance / ranks), faces / 3 * layers};
}

RankShare SpreadLiquid::fullest() const {
  double all = 0, most = -1, most_owned = -1;
  for (const double n : owned) all += n;
  RankShare share{static_cast<int>(owned.size()), 1, 0};
  for (std::size_t r = 0; r < owned.size(); ++r) {
    const double local = owned[r] + ghosts[r];
    if (!(all > 0) || local < most || (local == most && owned[r] <= most_owned)) continue;
    most = local;
    most_owned = owned[r];
    share.part = owned[r] / all;
    share.layer = std::cbrt(most) - std::cbrt(owned[r]);
  }
  return share;
}

SpreadLiquid spread(const std::vector<Vec3>& places, int ranks, double reach) {
  const auto n = static_cast<std::int64_t>(places.size()), points = std::min(n, points_of_rank * ranks);
  std::vector<WeightedPoint> seen;
  for (std::int64_t k = 0; k < points; ++k) seen.push_back({places[static_cast<std::size_t>(k * n / points)], 1});
  const Bisection cuts(std::move(seen), ranks);
  SpreadLiquid liquid;
  liquid.owned.assign(static_cast<std::size_t>(ranks), 0);
  liquid.ghosts = liquid.owned;
  for (const Vec3& x : places) {
    if (!finite(x)) continue;
    const int owner = cuts.rank_of(x);
    ++liquid.owned[static_cast<std::size_t>(owner)];
    cuts.near(x, reach, [&](int r) { liquid.ghosts[static_cast<std::size_t>(r)] += r != owner ? 1 : 0; });
  }
  return liquid;
}

}  // namespace drench
