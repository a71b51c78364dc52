#pragma once
// The precision of this build's backend, for tolerances.

#include "pipeline/backend.hpp"

namespace drench::test {

extern const bool double_precision;

/// One of two tolerances: the reference computes in double whatever the precision of the build is.
inline double allowed(const Backend& backend, double in_double, double in_float) {
  return double_precision || backend.name() == "reference" ? in_double : in_float;
}

}  // namespace drench::test
