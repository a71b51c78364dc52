#include "precision.hpp"

#include "drench_precision.hpp"

namespace drench::test {

#ifdef DRENCH_DOUBLE
constexpr bool double_precision = true;
#else
constexpr bool double_precision = false;
#endif

}  // namespace drench::test
