# cmake --install: the program, and the library for other programs with its find_package(drench).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

file(GLOB drench_sources CONFIGURE_DEPENDS src/drench/*.cpp)
add_library(drench_embed STATIC ${drench_sources} src/app/set_up.cpp src/app/resume.cpp)
set_target_properties(drench_embed PROPERTIES OUTPUT_NAME drench EXPORT_NAME drench)
target_include_directories(drench_embed PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/drench>)
target_compile_features(drench_embed INTERFACE cxx_std_20)
drench_unity(drench_embed 8)
target_link_options(drench_embed INTERFACE ${DRENCH_LINK_OPTIONS})
target_link_libraries(drench_embed PRIVATE $<BUILD_INTERFACE:drench_options> drench_reference drench_kokkos drench_core)

# The Kokkos of the build tree goes along; one that was found stays where it is.
if(FETCHCONTENT_BASE_DIR AND TARGET kokkos)
  install(SCRIPT ${kokkos_BINARY_DIR}/cmake_install.cmake)
  set(drench_kokkos_hint "\${PACKAGE_PREFIX_DIR}/${CMAKE_INSTALL_LIBDIR}/cmake/Kokkos")
else()
  set(drench_kokkos_hint ${Kokkos_DIR})
endif()

set_target_properties(drench PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
if(kokkos_is_debian)  # in .deps: CMake leaves folders of the project out of that path
  set_target_properties(drench PROPERTIES INSTALL_RPATH "${Kokkos_DIR}/../..")
endif()
install(TARGETS drench RUNTIME)
if(TARGET drench_view)
  install(TARGETS drench_view RUNTIME)
endif()
install(TARGETS drench_embed drench_core drench_reference drench_kokkos EXPORT drench-targets ARCHIVE)
# What <drench/drench.hpp> includes: no more of src/ is public.
install(FILES src/drench/drench.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/drench)
foreach(header base/types base/keyed parallel/communicator pipeline/runtime pipeline/step_report scene/liquid scene/load scene/material scene/motion scene/scene scene/scene_error setup/setup_error
    state/field_view state/fields state/host_state)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES src/${header}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/drench/${folder})
endforeach()
install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/drench/scenes PATTERN gallery EXCLUDE)
install(DIRECTORY tools/export/ DESTINATION ${CMAKE_INSTALL_DATADIR}/drench/export FILES_MATCHING PATTERN *.py PATTERN *.json)
install(FILES tools/completion/drench.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME drench)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/drench)
install(EXPORT drench-targets NAMESPACE drench:: DESTINATION ${config_folder})
configure_package_config_file(tools/cmake/drench-config.cmake.in generated/drench-config.cmake
  INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(generated/drench-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/generated/drench-config.cmake ${PROJECT_BINARY_DIR}/generated/drench-config-version.cmake
  DESTINATION ${config_folder})
