# cmake -C tools/presets/cuda.cmake -S . -B build/cuda-float [-DDRENCH_CUDA_ARCH=90] [-DDRENCH_PRECISION=double]
# The toolkit is the nvcc on the PATH, or the one under CUDA_ROOT. Files that hold kernels go through Kokkos' nvcc_wrapper,
# everything else through the ordinary compiler.
set(DRENCH_BACKEND cuda CACHE STRING "")
set(DRENCH_CUDA_ARCH 90 CACHE STRING "Compute capability of the GPU: 61, 75, 80, 86, 89 or 90")
if(DEFINED ENV{CUDA_ROOT})
  set(CUDAToolkit_ROOT $ENV{CUDA_ROOT} CACHE PATH "")
endif()
