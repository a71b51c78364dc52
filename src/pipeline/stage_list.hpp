#pragma once
// The pipeline's one list: every stage in the order in which it runs, and when a scene needs it (`m` is the Model).
// A stage that is not needed is not run, timed or given memory. The stage `absorption` is src/stages/absorption.hpp
// (its law), backends/kokkos/absorption.cpp, reference/absorption.cpp and tests/stages/absorption_test.cpp.

#include <array>
#include <string_view>

// clang-format off
#define DRENCH_STAGES(STAGE)                                                                  \
  STAGE(time_step,         true)                                                              \
  STAGE(prescribed_motion, m.has_keyed_body())                                                \
  STAGE(neighbors,         m.has_fluid())                                                     \
  STAGE(density,           m.has_fluid())                                                     \
  STAGE(divergence,        m.has_moving_liquid())                                             \
  STAGE(rotating_frame,    m.scene.rotating_frame.acts(m.has_moving_cloth(), m.has_moving_liquid())) \
  STAGE(forces,            m.has_moving_liquid())                                             \
  STAGE(micropolar,        m.has_micropolar())                                                \
  STAGE(surface_tension,   m.has_surface_forces())                                            \
  STAGE(wet_adhesion,      m.has_wet_adhesion())                                              \
  STAGE(wind,              m.scene.wind.blows(m.has_moving_cloth(), m.has_moving_liquid()))   \
  STAGE(cloth,             m.has_moving_cloth())                                              \
  STAGE(pressure,          m.has_moving_liquid())                                             \
  STAGE(self_collision,    m.has_self_collision())                                            \
  STAGE(evaporation,       m.has_evaporation())                                               \
  STAGE(advection,         m.has_fluid() || m.has_moving_cloth())                             \
  STAGE(squeezing,         m.has_squeezing())                                                 \
  STAGE(bodies,            m.has_body_state())                                                \
  STAGE(jets,              m.has_jets())                                                      \
  STAGE(porous_neighbors,  m.meets_porous() || m.has_diffusion())                             \
  STAGE(flow_direction,    m.has_exchange() && m.has_direction())                             \
  STAGE(permeation,        m.has_permeation())                                                \
  STAGE(drying,            m.has_drying())                                                    \
  STAGE(absorption,        m.has_absorption())                                                \
  STAGE(emission,          m.has_emission())                                                  \
  STAGE(diffusion,         m.has_diffusion())                                                 \
  STAGE(reservoir,         m.has_reservoirs())                                                \
  STAGE(measures,          m.has_measures())                                                  \
  STAGE(fabric,            m.has_fabric())                                                    \
  STAGE(ledger,            true)

/// The forces among them that change velocities alone, and how fast each of them can make things by itself, m/s.
#define DRENCH_FORCES(FORCE)                                            \
  FORCE(rotating_frame, m.scene.rotating_frame.fastest(m.scene.domain)) \
  FORCE(wind,           m.scene.wind.fastest())
// clang-format on

namespace drench {

enum class Stage : int {
#define DRENCH_STAGE_ENUM(name, when) name,
  DRENCH_STAGES(DRENCH_STAGE_ENUM)
#undef DRENCH_STAGE_ENUM
};

inline constexpr std::array stage_names{
#define DRENCH_STAGE_NAME(name, when) std::string_view(#name),
    DRENCH_STAGES(DRENCH_STAGE_NAME)
#undef DRENCH_STAGE_NAME
};

inline constexpr int stage_count = static_cast<int>(stage_names.size());
constexpr std::string_view name_of(Stage s) { return stage_names[static_cast<std::size_t>(s)]; }

}  // namespace drench
