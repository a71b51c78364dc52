# cmake -C tools/presets/openmp.cmake -S . -B build/openmp-float [-DDRENCH_PRECISION=double]
set(DRENCH_BACKEND openmp CACHE STRING "")
