# cmake -C tools/presets/cuda.cmake -S . -B build/cuda-float [-DDRENCH_CUDA_ARCH=89|all] [-DDRENCH_PRECISION=double]
# The program is compiled for the GPUs of this machine unless DRENCH_CUDA_ARCH names others (tools/cmake/cuda_arch.cmake).
# The toolkit is the nvcc on the PATH, or the one under CUDA_ROOT. Files that hold kernels go through Kokkos' nvcc_wrapper,
# everything else through the ordinary compiler.
set(DRENCH_BACKEND cuda CACHE STRING "")
