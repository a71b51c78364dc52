# Finds or fetches Kokkos; sets DRENCH_LINK_OPTIONS for executables. In this order:
# 1. an installed Kokkos >= 4.6 that has the backend (name its prefix in CMAKE_PREFIX_PATH),
# 2. the sources in FETCHCONTENT_SOURCE_DIR_KOKKOS,
# 3. the release below, from GitHub, in .deps,
# 4. the sources of Debian unstable's package, in .deps, by tools/setup,
# 5. that package itself (OpenMP only), in .deps, by tools/setup. It brings a C library of its own, which a running Python
#    cannot load: the Python package needs one of the others.
set(DRENCH_LINK_OPTIONS "")
# The first release for CUDA 13 too; the checksum is that of Spack's and Homebrew's recipes.
set(kokkos_release 4.7.01)
set(kokkos_checksum 404cf33e76159e83b8b4ad5d86f6899d442b5da4624820ab457412116cdcd201)
set(kokkos_url https://github.com/kokkos/kokkos/releases/download/${kokkos_release}/kokkos-${kokkos_release}.tar.gz)
set(kokkos_archive ${PROJECT_SOURCE_DIR}/.deps/kokkos-${kokkos_release}.tar.gz)
set(kokkos_debian ${PROJECT_SOURCE_DIR}/.deps/kokkos)
set(kokkos_debian_source ${PROJECT_SOURCE_DIR}/.deps/kokkos-source)
string(TOUPPER ${DRENCH_BACKEND} kokkos_device)

if(DRENCH_BACKEND STREQUAL cuda)
  # Kokkos' nvcc_wrapper asks CUDA_ROOT for its nvcc. The CUDA run-time is linked statically.
  # CMake 3.25.1 fails at a toolkit without nvToolsExt, such as CUDA 13, in projects that require CMake 3.25.
  set(required ${CMAKE_MINIMUM_REQUIRED_VERSION})
  set(CMAKE_MINIMUM_REQUIRED_VERSION 3.24)
  if(DEFINED ENV{CUDA_ROOT} AND NOT CUDAToolkit_ROOT)
    set(CUDAToolkit_ROOT $ENV{CUDA_ROOT})
  endif()
  find_package(CUDAToolkit 12 QUIET)  # C++20
  set(CMAKE_MINIMUM_REQUIRED_VERSION ${required})
  if(NOT CUDAToolkit_FOUND)
    message(FATAL_ERROR "No CUDA 12 or newer found: install one, and set CUDA_ROOT to its folder if nvcc is not on the PATH")
  endif()
  include(tools/cmake/cuda_arch.cmake)
  drench_choose_cuda_archs(${CUDAToolkit_NVCC_EXECUTABLE} ${CUDAToolkit_VERSION_MAJOR}.${CUDAToolkit_VERSION_MINOR})
  if(cuda_fault)
    message(FATAL_ERROR "${cuda_fault}")
  endif()
  foreach(line IN LISTS cuda_messages)
    message(STATUS "CUDA: ${line}")
  endforeach()
  list(GET cuda_archs 0 cuda_oldest)
  cmake_path(GET CUDAToolkit_BIN_DIR PARENT_PATH cuda_root)
  set(ENV{CUDA_ROOT} ${cuda_root})
  get_target_property(cudart_static CUDA::cudart_static IMPORTED_LOCATION)
  set_target_properties(CUDA::cudart PROPERTIES IMPORTED_LOCATION ${cudart_static}
    INTERFACE_LINK_LIBRARIES CUDA::cudart_static)
endif()

# Puts the release into .deps, once for all build trees. `failed`: why not, or empty.
function(fetch_kokkos_release failed)
  set(${failed} "" PARENT_SCOPE)
  if(EXISTS ${kokkos_archive})
    return()
  endif()
  file(DOWNLOAD https://github.com/robots.txt STATUS status TIMEOUT 10)  # quick where there is no network
  list(POP_FRONT status code)
  if(code EQUAL 0)
    message(STATUS "Downloading Kokkos ${kokkos_release}")
    string(RANDOM suffix)
    file(DOWNLOAD ${kokkos_url} ${kokkos_archive}.${suffix} STATUS status TIMEOUT 600)
    list(POP_FRONT status code)
  endif()
  if(code EQUAL 0)
    file(SHA256 ${kokkos_archive}.${suffix} checksum)
    if(checksum STREQUAL kokkos_checksum)
      file(RENAME ${kokkos_archive}.${suffix} ${kokkos_archive})
      return()
    endif()
    set(status "its checksum is ${checksum}")
  endif()
  file(REMOVE ${kokkos_archive}.${suffix})
  message(STATUS "Kokkos ${kokkos_release} cannot be downloaded from GitHub: ${status}")
  set(${failed} "${status}" PARENT_SCOPE)
endfunction()

set(kokkos_from "")
if(DRENCH_PYTHON AND NOT FETCHCONTENT_SOURCE_DIR_KOKKOS AND DEFINED ENV{FETCHCONTENT_SOURCE_DIR_KOKKOS})
  set(FETCHCONTENT_SOURCE_DIR_KOKKOS $ENV{FETCHCONTENT_SOURCE_DIR_KOKKOS})
endif()
find_package(Kokkos 4.6 CONFIG QUIET)
if(Kokkos_FOUND)
  # A Kokkos with CUDA would run on the GPU, whatever else it has.
  if(NOT kokkos_device IN_LIST Kokkos_DEVICES OR (CUDA IN_LIST Kokkos_DEVICES AND NOT kokkos_device STREQUAL CUDA))
    message(FATAL_ERROR "The Kokkos in ${Kokkos_DIR} is for ${Kokkos_DEVICES}, not for ${kokkos_device}: "
      "name another in CMAKE_PREFIX_PATH, or pass -DCMAKE_DISABLE_FIND_PACKAGE_Kokkos=ON to fetch one")
  endif()
  if(DRENCH_BACKEND STREQUAL cuda AND Kokkos_ARCH AND NOT "${kokkos_arch_of_${cuda_oldest}}" IN_LIST Kokkos_ARCH)
    message(FATAL_ERROR "The Kokkos in ${Kokkos_DIR} is for ${Kokkos_ARCH}, and this build needs one for "
      "${kokkos_arch_of_${cuda_oldest}}: pass -DCMAKE_DISABLE_FIND_PACKAGE_Kokkos=ON to compile it too")
  endif()
  if(DRENCH_BACKEND STREQUAL cuda AND CUDAToolkit_VERSION VERSION_GREATER_EQUAL 12.9 AND Kokkos_VERSION VERSION_LESS 5
      AND NOT IMPL_VIEW_LEGACY IN_LIST Kokkos_OPTIONS)
    message(FATAL_ERROR "The Kokkos ${Kokkos_VERSION} in ${Kokkos_DIR} breaks with CUDA ${CUDAToolkit_VERSION} "
      "(kokkos/mdspan#434): configure it with Kokkos_ENABLE_IMPL_MDSPAN=OFF, or take Kokkos 5")
  endif()
  set(kokkos_from ${Kokkos_DIR})
elseif(FETCHCONTENT_SOURCE_DIR_KOKKOS)
  set(kokkos_from source)
elseif(DRENCH_BACKEND STREQUAL openmp AND EXISTS ${kokkos_debian} AND NOT DRENCH_PYTHON)
  set(kokkos_from debian)
elseif(EXISTS ${kokkos_debian_source} AND NOT EXISTS ${kokkos_archive})
  set(FETCHCONTENT_SOURCE_DIR_KOKKOS ${kokkos_debian_source})
  set(kokkos_from source)
else()
  fetch_kokkos_release(failed)
  if(NOT failed)
    set(kokkos_from source)
  else()
    execute_process(COMMAND ${PROJECT_SOURCE_DIR}/tools/setup kokkos_source RESULT_VARIABLE failed)
    if(failed STREQUAL 0)
      set(FETCHCONTENT_SOURCE_DIR_KOKKOS ${kokkos_debian_source})
      set(kokkos_from source)
    elseif(DRENCH_BACKEND STREQUAL openmp AND NOT DRENCH_PYTHON)
      execute_process(COMMAND ${PROJECT_SOURCE_DIR}/tools/setup kokkos RESULT_VARIABLE failed)
      if(failed STREQUAL 0)
        set(kokkos_from debian)
      endif()
    endif()
  endif()
  if(NOT kokkos_from)
    message(NOTICE "drench: Kokkos is neither installed nor can it be downloaded: unpack ${kokkos_url} "
      "and set FETCHCONTENT_SOURCE_DIR_KOKKOS to its folder")  # CMake would break the line of an error
    message(FATAL_ERROR "No Kokkos 4.6 or newer")
  endif()
endif()

if(kokkos_from STREQUAL source)
  include(FetchContent)
  set(Kokkos_ENABLE_SERIAL ON CACHE BOOL "")
  # With the [[no_unique_address]] members of mdspan g++ 12 left static Views zero, and from CUDA 12.9 on nvcc and g++ lay
  # them out differently: kernels get wrong pointers (docs/dev/portability.md).
  set(Kokkos_ENABLE_IMPL_MDSPAN OFF CACHE BOOL "")
  set(Kokkos_ENABLE_${kokkos_device} ON CACHE BOOL "")
  if(DRENCH_BACKEND STREQUAL cuda)
    set(Kokkos_ENABLE_OPENMP ON CACHE BOOL "")
    foreach(arch IN LISTS drench_all_cuda_archs)  # Kokkos takes one; an earlier configure may have set another
      unset(Kokkos_ARCH_${kokkos_arch_of_${arch}} CACHE)
    endforeach()
    set(Kokkos_ARCH_${kokkos_arch_of_${cuda_oldest}} ON CACHE BOOL "")
  endif()
  set(BUILD_SHARED_LIBS OFF CACHE BOOL "")
  FetchContent_Declare(Kokkos SYSTEM EXCLUDE_FROM_ALL URL ${kokkos_archive} URL_HASH SHA256=${kokkos_checksum})
  FetchContent_MakeAvailable(Kokkos)
  get_directory_property(Kokkos_VERSION DIRECTORY ${kokkos_SOURCE_DIR} DEFINITION Kokkos_VERSION)
elseif(kokkos_from STREQUAL debian)
  set(CMAKE_DISABLE_FIND_PACKAGE_Kokkos OFF)  # that switch is meant for installed ones
  find_package(Kokkos 4.6 CONFIG REQUIRED PATHS ${kokkos_debian} NO_DEFAULT_PATH)
endif()
cmake_path(IS_PREFIX kokkos_debian "${Kokkos_DIR}" kokkos_is_debian)  # also when a later run finds it in the cache
if(kokkos_is_debian)
  # It needs a newer C library than this system has, and brings one: programs run with that.
  set(runtime ${kokkos_debian}/runtime)
  file(GLOB loader ${runtime}/ld-linux*)
  set(DRENCH_LINK_OPTIONS -Wl,--dynamic-linker=${loader} -Wl,--disable-new-dtags -Wl,-rpath,${runtime}
      -Wl,--allow-shlib-undefined)
endif()
if(DRENCH_BACKEND STREQUAL cuda AND CUDAToolkit_VERSION VERSION_GREATER_EQUAL 13 AND Kokkos_VERSION VERSION_LESS 4.7.01)
  message(FATAL_ERROR "CUDA ${CUDAToolkit_VERSION} needs Kokkos >= 4.7.01, this is ${Kokkos_VERSION} (${kokkos_from})")
endif()
if(DRENCH_BACKEND STREQUAL cuda)  # whatever CUDA_ROOT is when the build runs, the nvcc is the one found here
  # Kokkos compiles for the oldest capability. nvcc_wrapper refuses flags for more, so nvcc gets them from its environment.
  string(STRIP "${cuda_nvcc_flags} $ENV{NVCC_APPEND_FLAGS}" nvcc_flags)
  if(nvcc_flags)
    set(nvcc_flags "\"NVCC_APPEND_FLAGS=${nvcc_flags}\"")
  endif()
  foreach(rule RULE_LAUNCH_COMPILE RULE_LAUNCH_LINK)
    get_property(launcher GLOBAL PROPERTY ${rule})
    set_property(GLOBAL PROPERTY ${rule} "${CMAKE_COMMAND} -E env CUDA_ROOT=${cuda_root} ${nvcc_flags} ${launcher}")
  endforeach()
endif()
message(STATUS "Kokkos ${Kokkos_VERSION} (${DRENCH_BACKEND}, ${DRENCH_PRECISION}): ${kokkos_from}")
