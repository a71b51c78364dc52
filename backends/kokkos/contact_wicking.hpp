#pragma once
// Liquid that passes between layers of cloth that touch: laws 4–6 of src/stages/diffusion.hpp.

#include "device.hpp"

namespace drench::kokkos_backend {

/// Which samples touch what, and how well it conducts in sub-steps of dt (s), in contact_work.
void find_contacts(Device& d, double dt, bool with_momentum);
/// One sub-step; `with_momentum` changes diffusion_work.velocity.
void wick_through_contacts(Device& d, double dt, bool with_momentum);

}  // namespace drench::kokkos_backend
