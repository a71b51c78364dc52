#pragma once
// The labels of what a scene launches and allocates: watched through Kokkos Tools.

#include <Kokkos_Core.hpp>
#include <initializer_list>
#include <set>
#include <string>

#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "stage_compare.hpp"

namespace drench::test {

/// Of the last Watch.
inline std::set<std::string> launched, allocated;
/// On a device Kokkos names the host's copy of an array after it.
inline bool is_copy(const char* name) { return std::string(name).find("_mirror") != std::string::npos; }
inline void on_launch(const char* name, const uint32_t, uint64_t* id) {
  if (!is_copy(name)) launched.insert(name);
  *id = 0;
}
inline void on_allocate(Kokkos_Profiling_SpaceHandle, const char* name, const void*, const uint64_t) {
  if (!is_copy(name)) allocated.insert(name);
}

/// Labels of kernels and arrays while a scene runs a few steps.
struct Watch {
  explicit Watch(const std::string& scene) {
    launched.clear();
    allocated.clear();
    Kokkos::Tools::Experimental::set_begin_parallel_for_callback(on_launch);
    Kokkos::Tools::Experimental::set_begin_parallel_reduce_callback(on_launch);
    Kokkos::Tools::Experimental::set_begin_parallel_scan_callback(on_launch);
    Kokkos::Tools::Experimental::set_allocate_data_callback(on_allocate);
    const auto setup = setup_from(scene);
    {
      const auto backend = make_kokkos_backend(setup.model);
      Pipeline pipeline(setup.model, *backend, setup.state);
      for (int s = 0; s < 4; ++s) pipeline.step(1.0);
    }
    Kokkos::Tools::Experimental::set_begin_parallel_for_callback(nullptr);
    Kokkos::Tools::Experimental::set_begin_parallel_reduce_callback(nullptr);
    Kokkos::Tools::Experimental::set_begin_parallel_scan_callback(nullptr);
    Kokkos::Tools::Experimental::set_allocate_data_callback(nullptr);
  }
};

/// How many of the labels have one of these in them.
inline int containing(const std::set<std::string>& labels, std::initializer_list<const char*> parts) {
  int n = 0;
  for (const std::string& label : labels)
    for (const char* part : parts)
      if (label.find(part) != std::string::npos) {
        ++n;
        break;
      }
  return n;
}

inline const std::initializer_list<const char*> porous_labels = {"::absorption",     "::emission",    "::diffusion",
                                                                 "::flow_direction", "::reservoir",   "::transfer",
                                                                 "saturation",       "flow_direction"};

}  // namespace drench::test
