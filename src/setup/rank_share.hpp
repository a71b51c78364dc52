#pragma once
// How the liquid of a scene is spread over ranks, for the estimate of a rank's memory.

#include <vector>

#include "base/types.hpp"

namespace drench {

/// The share of the rank that has most particles, owned and ghosts together. Its ghosts are a layer round a cube of its
/// own particles, so that they grow as n^(2/3).
struct RankShare {
  int ranks = 1;
  double part = 1;                        // of all particles that the rank owns
  double layer = 0;                       // spacings by which the cube is wider with its ghosts
  double ghosts(double particles) const;  ///< of that rank, where the scene has so many particles
};

/// Of liquid that is not there yet: a compact body, where a cut halves it, and its parts again. `reach`: the width of
/// the ghosts' layer, in spacings. Cuts follow where the fullest rank has a tenth more than the mean.
RankShare expected_share(int ranks, double reach);

struct SpreadLiquid {
  std::vector<double> owned, ghosts;  // particles of each rank
  RankShare fullest() const;
};
/// Cuts these places as a run's start does (backends/kokkos/particles/exchange.cpp), and counts. `reach`: m. Places
/// that are no numbers count nowhere.
SpreadLiquid spread(const std::vector<Vec3>& places, int ranks, double reach);

}  // namespace drench
