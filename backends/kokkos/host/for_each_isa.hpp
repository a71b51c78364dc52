// Compiles DRENCH_ISA_FILE for each instruction set of a host: namespaces isa_portable, isa_avx2 and isa_avx512, with
// DRENCH_ISA_BITS 128, 256 and 512. best_isa() chooses the one that runs. Nothing is contracted to fused multiply-adds,
// so all of them compute the same bits. (No pragma once: a file of code may include it several times.)

#include "host/isa.hpp"

#ifdef DRENCH_LANES
#define DRENCH_ISA_BITS 128
namespace drench::kokkos_backend::isa_portable {
#include DRENCH_ISA_FILE
}
#undef DRENCH_ISA_BITS
#endif
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
