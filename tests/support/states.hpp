#pragma once
// States that tests compare and make.

#include <string>
#include <vector>

#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench::test {

/// A number in [−1, 1] that has nothing to do with its neighbours': for axis `a` of entry `n`.
double noise(std::size_t n, int a);

/// Pairs of particles nearer to each other than `near`, m.
int close_pairs(const HostState& s, double near);

/// The names of the fields in which two states are not the same bits; "" if there is none.
std::string different_bits(const HostState& a, const HostState& b);

/// Leaves of the liquid the particles `which`, in that order, in each of its arrays that there are.
void keep_liquid(HostState& s, const std::vector<std::size_t>& which);

/// The sample of the cloths that is nearest to x (m) and nearer than `reach`, and its triangle's unit normal; 0 if none
/// is.
struct NearestSample {
  Vec3 position{0, 0, 0}, normal{0, 0, 0};
  bool found = false;
};
NearestSample nearest_sample(const Model& model, const HostState& s, const Vec3& x, double reach);

}  // namespace drench::test
