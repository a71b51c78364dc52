// Compiles DRENCH_ISA_FILE for each instruction set that a host's processor may have, each in a namespace of its own:
// isa_portable, isa_avx2, isa_avx512, with DRENCH_ISA_BITS 128, 256 and 512. (No pragma once: it is included once a file of code.) `best_isa()` tells which one this
// processor can run. Without contraction to fused multiply-adds all of them compute the same bits.

#include "core/isa.hpp"

#define DRENCH_ISA_BITS 128
namespace drench::kokkos_backend::isa_portable {
#include DRENCH_ISA_FILE
}
#undef DRENCH_ISA_BITS
#ifdef DRENCH_SEVERAL_ISAS
#pragma GCC push_options
#pragma GCC target("avx2")
#define DRENCH_ISA_BITS 256
namespace drench::kokkos_backend::isa_avx2 {
#include DRENCH_ISA_FILE
}
#undef DRENCH_ISA_BITS
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx2,avx512f,avx512vl,avx512bw,avx512dq")
#define DRENCH_ISA_BITS 512
namespace drench::kokkos_backend::isa_avx512 {
#include DRENCH_ISA_FILE
}
#undef DRENCH_ISA_BITS
#pragma GCC pop_options
#endif
#undef DRENCH_ISA_FILE
