#include "pipeline/substeps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/failure.hpp"

namespace drench {

int diffusion_substeps(double wanted, const StepInfo& info, const StepReport& report) {
  constexpr double most = 1e6;
  if (wanted > most)
    throw RunFailure(FailureKind::sub_steps, Stage::diffusion, info, report,
                     fmt::format("it asks for {:.3g} sub-steps, more than {:.0f}", wanted, most));
  return std::max(1, static_cast<int>(std::ceil(wanted)));
}

}  // namespace drench
