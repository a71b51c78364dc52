# drench-view, the window of `drench view`, where VTK's drawing parts and X11 are. Without them drench has neither the
# command nor `drench run --view`. A program of its own: drench itself links nothing that draws.
option(DRENCH_VIEW "Build drench view where VTK can draw" ON)
set(DRENCH_HAS_VIEW FALSE)
if(DRENCH_VIEW)
  set(view_components FiltersGeometry FiltersModeling InteractionStyle InteractionWidgets IOImage IOOggTheora
      RenderingAnnotation RenderingCore RenderingFreeType RenderingOpenGL2)
  find_package(VTK 9.1 QUIET COMPONENTS ${view_components} HINTS ${VTK_DIR})
  find_package(X11 QUIET)
  if(VTK_FOUND AND X11_FOUND)
    set(DRENCH_HAS_VIEW TRUE)
  endif()
endif()
if(NOT DRENCH_HAS_VIEW)
  message(STATUS "No drench view: VTK's drawing parts or X11 are not here")
  return()
endif()

file(READ ${PROJECT_SOURCE_DIR}/tools/saturation.json saturation)
string(JSON saturation_points GET "${saturation}" 0 RGBPoints)
string(REGEX REPLACE "[][]" "" saturation_points "${saturation_points}")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS tools/saturation.json)
configure_file(src/view/view_colors.hpp.in generated/view_colors.hpp)

file(GLOB view_sources CONFIGURE_DEPENDS src/view/*.cpp)
list(TRANSFORM view_components PREPEND VTK:: OUTPUT_VARIABLE view_libraries)
add_executable(drench_view ${view_sources})
set_target_properties(drench_view PROPERTIES OUTPUT_NAME drench-view)
target_link_libraries(drench_view PRIVATE drench_options drench_core CLI11::CLI11 X11::X11 ${view_libraries})

# drench reads the same command line and then becomes drench-view.
target_sources(drench PRIVATE src/view/options.cpp src/view/named_view.cpp)
target_compile_definitions(drench PRIVATE DRENCH_HAS_VIEW)
add_dependencies(drench drench_view)
