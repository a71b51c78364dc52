#include <fmt/format.h>

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include "app/commands.hpp"
#include "app/import_formats.hpp"
#include "app/set_up.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/runtime.hpp"
#include "setup/first_scene.hpp"

namespace drench {
namespace {

constexpr int tried_steps = 10;

/// A step that fails counts as one that does not converge.
/// Ends with the first step that does not converge or fails: such a step takes the longest.
bool first_steps_converge(const Scene& scene) {
  const Setup setup = build(scene, memory_budget());
  const std::unique_ptr<Backend> backend = make_kokkos_backend_on(nullptr, setup.model);
  Pipeline pipeline(setup.model, *backend, setup.state);
  try {
    for (int k = 0; k < tried_steps; ++k)
      if (!pipeline.step(std::numeric_limits<double>::infinity()).cloth_converged) return false;
  } catch (const std::runtime_error&) {
    return false;
  }
  return true;
}

/// The file itself, or what it is imported as; "" of none.
std::string mesh_of(const std::string& file, const std::optional<std::string>& prim) {
  return is_imported(file) ? imported_mesh(file, prim) : file;
}

}  // namespace

int new_command(const NewOptions& options) {
  const std::string mesh = mesh_of(options.mesh, options.prim), body = mesh_of(options.body, options.body_prim);
  std::optional<BackendRuntime> runtime;
  TrySteps trial;  // none without a device: then the steps are only estimated
  try {
    require_device();
    runtime.emplace(options.threads, true);
    trial = [trials = 0](const Scene& scene) mutable {
      if (++trials > 1)
        fmt::print(stderr, "trying the first steps with a time.step of {:g} s and bend {:g} N m\n", scene.time.step,
                   scene.cloths.front().material.bend);
      return first_steps_converge(scene);
    };
  } catch (const DeviceError&) {
  }
  const FirstScene scene = first_scene(mesh, body, trial);
  for (const std::string& line : scene.warnings) fmt::print(stderr, "warning: {}\n", line);
  fmt::print("{}", scene.yaml);
  return exit_done;
}

}  // namespace drench
