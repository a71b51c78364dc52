#pragma once
// Tests that mpirun starts as several ranks: every rank runs every test, on the same states.

#include "parallel/communicator.hpp"
#include "state/host_state.hpp"

namespace drench::test {

/// The ranks that run these tests together; null for one alone. main() joins them.
const Communicator* test_ranks();
/// Joins the ranks, until it is destroyed; only rank 0 prints from then on.
class JoinedRanks {
 public:
  JoinedRanks();
  ~JoinedRanks();
  JoinedRanks(const JoinedRanks&) = delete;
  JoinedRanks& operator=(const JoinedRanks&) = delete;

 private:
  std::unique_ptr<Communicator> ranks_;
};

/// Every rank's state becomes that of rank 0, which has all of the liquid. Alone it stays as it is.
void share_state(HostState& state);
/// A number that two states have in common only where all their bits agree, but for chance.
std::uint64_t bits_of(const HostState& state);

}  // namespace drench::test
