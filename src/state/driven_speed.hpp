#pragma once

#include "state/model.hpp"

namespace drench {

/// The fastest that a scene drives its cloths at the start, its pins, its bodies and the motors of its hinges, m/s;
/// with what a program commands the bodies to do.
double driven_speed(const Model& model);

}  // namespace drench
