#include "pipeline/substeps.hpp"

#include <fmt/format.h>

#include "pipeline/failure.hpp"
#include "stages/substeps.hpp"

namespace drench {

int diffusion_substeps_within_limit(double rate, const StepInfo& info, const StepReport& report) {
  constexpr double most = 1e6;
  const double wanted = substeps_for(rate, info.dt);
  if (wanted > most)
    throw RunFailure(FailureKind::sub_steps, Stage::diffusion, info, report,
                     fmt::format("it requires {:.3g} sub-steps, more than {:.0f}", wanted, most));
  return static_cast<int>(wanted);
}

}  // namespace drench
