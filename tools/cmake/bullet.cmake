# Bullet's rigid bodies in double precision: the target drench_bullet with its headers, and drench_bullet_libraries. Debian
# and Ubuntu name these libraries -float64.
find_path(DRENCH_BULLET_INCLUDE btBulletDynamicsCommon.h PATH_SUFFIXES bullet)
add_library(drench_bullet INTERFACE)
target_compile_definitions(drench_bullet INTERFACE BT_USE_DOUBLE_PRECISION)
target_include_directories(drench_bullet SYSTEM INTERFACE ${DRENCH_BULLET_INCLUDE})
foreach(library BulletDynamics BulletCollision LinearMath)
  find_library(DRENCH_${library} NAMES ${library}-float64)
  if(NOT DRENCH_${library} OR NOT DRENCH_BULLET_INCLUDE)
    message(FATAL_ERROR "Bullet in double precision was not found (${library}-float64): install libbullet-dev")
  endif()
  list(APPEND drench_bullet_libraries ${DRENCH_${library}})
endforeach()
mark_as_advanced(DRENCH_BULLET_INCLUDE DRENCH_BulletDynamics DRENCH_BulletCollision DRENCH_LinearMath)
