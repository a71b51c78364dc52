#pragma once
// On which side of which sheet the liquid is (src/stages/neighbors.hpp), shared by the stages neighbors and pressure.

#include "common.hpp"

namespace drench::reference {

/// The sample of the cloths nearest to particle i within h, the first in the list of several; −1: none.
Index nearest_sample(const ReferenceState& state, Index i);

/// Unit normal of the sample's triangle.
Eigen::Vector3d sample_normal(const ReferenceState& state, Index p);

/// Whether c (m), in the plane of sample p, is on its sheet near the sample: nearer than 1.25 d and not beyond the
/// boundary.
bool on_sheet(const ReferenceState& state, Index p, const Eigen::Vector3d& c);

/// Whether particle i touches a sheet (src/stages/pressure.hpp).
bool touches_sheet(const ReferenceState& state, Index i);

}  // namespace drench::reference
