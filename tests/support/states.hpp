#pragma once
// States that tests compare and make.

#include <string>
#include <vector>

#include "state/host_state.hpp"

namespace drench::test {

/// The names of the fields in which two states are not the same bits; "" if there is none.
std::string different_bits(const HostState& a, const HostState& b);

/// Leaves of the liquid the particles `which`, in that order, in each of its arrays that there are.
void keep_liquid(HostState& s, const std::vector<std::size_t>& which);

}  // namespace drench::test
