#include "host/isa.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace drench::kokkos_backend {

Isa best_isa() {
  static const Isa best = [] {
    Isa has = Isa::portable, most = Isa::avx512;
#ifdef DRENCH_SEVERAL_ISAS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2")) has = Isa::avx2;
    if (has == Isa::avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
      has = Isa::avx512;
#endif
    if (const char* asked = std::getenv("DRENCH_ISA")) {
      if (std::string_view(asked) == "portable") most = Isa::portable;
      if (std::string_view(asked) == "avx2") most = Isa::avx2;
    }
    return std::min(has, most);
  }();
  return best;
}

}  // namespace drench::kokkos_backend
