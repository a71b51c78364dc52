#include "pipeline/runtime.hpp"

#include <fmt/format.h>

namespace drench {
namespace {

std::string capability(int number) { return fmt::format("{}.{} (sm_{})", number / 10, number % 10, number); }

}  // namespace

std::string no_device_text(std::string_view reason, int built_for) {
  return fmt::format(
      "no CUDA device: {}; this build requires a GPU of compute capability {} or newer; --backend reference runs "
      "without",
      reason, capability(built_for));
}

std::string wrong_device_text(std::string_view device, int has, int built_for) {
  return fmt::format("{} has compute capability {}, this build needs {} or newer: build with -DDRENCH_CUDA_ARCH={}",
                     device, capability(has), capability(built_for), has);
}

}  // namespace drench
