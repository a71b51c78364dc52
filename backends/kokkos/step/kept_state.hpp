#pragma once
// A copy of the state at the beginning of a step, which a shorter step goes back to (time.mode error).

#include <cstddef>
#include <vector>

#include "cloth/cloth.hpp"
#include "fluid/stages.hpp"
#include "particles/fluid.hpp"
#include "state/host_state.hpp"

namespace drench::kokkos_backend {

class KeptState {
 public:
  void keep(Fluid& fluid, Bodies& bodies, Cloth& cloth, const Accounts& accounts, const Jets& jets);
  /// Everything is as it was kept, and what was derived from it is not of it any more.
  void go_back(Fluid& fluid, Bodies& bodies, Cloth& cloth, Accounts& accounts, Jets& jets) const;

 private:
  std::vector<Array<std::byte>> arrays_;  // in the order of the table of fields
  Index particles_ = 0;
  std::int64_t next_id_ = 0;
  Accounts accounts_;
  std::vector<std::int64_t> jet_particles_;
};

MemoryEstimate kept_state_bytes(const Sizing& s);

}  // namespace drench::kokkos_backend
