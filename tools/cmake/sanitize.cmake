# Everything that is compiled here watches itself: a fault ends the program with a line that says where.
if(NOT DRENCH_SANITIZE MATCHES "^(address|thread)$" OR DRENCH_BACKEND STREQUAL cuda)
  message(FATAL_ERROR "DRENCH_SANITIZE is '${DRENCH_SANITIZE}', allowed: address, thread; with DRENCH_BACKEND openmp or serial")
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Debug CACHE STRING "" FORCE)
  set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1" CACHE STRING "" FORCE)  # without NDEBUG: Eigen's own checks are on
endif()
if(DRENCH_SANITIZE STREQUAL address)
  set(sanitizers address,undefined,float-cast-overflow)
  # Indices into Views: past a row's end is still inside the allocation. The names of the Views need no rebuilt Kokkos.
  add_compile_definitions(KOKKOS_ENABLE_DEBUG_BOUNDS_CHECK)
else()
  set(sanitizers thread)
endif()
add_compile_options(-fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # g++ takes what the sanitizers add for values that were never set (in std::regex)
  add_compile_options(-Wno-maybe-uninitialized)
endif()
add_compile_definitions(_GLIBCXX_ASSERTIONS)  # indices into vectors
add_link_options(-fsanitize=${sanitizers})
