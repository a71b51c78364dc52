#include "pipeline/substeps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/pipeline.hpp"

namespace drench {

int diffusion_substeps(double wanted, std::int64_t step) {
  constexpr double most = 1e6;
  if (wanted > most)
    throw RunFailure(
        Stage::diffusion, step,
        fmt::format("it asks for {:.3g} sub-steps, more than {:.0f}: lower time.step or porous.diffusivity, or "
                    "take larger triangles",
                    wanted, most));
  return std::max(1, static_cast<int>(std::ceil(wanted)));
}

}  // namespace drench
