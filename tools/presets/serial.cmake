# cmake -C tools/presets/serial.cmake -S . -B build/serial-float [-DDRENCH_PRECISION=double]
set(DRENCH_BACKEND serial CACHE STRING "")
