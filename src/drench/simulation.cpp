#include <stdexcept>

#include "app/set_up.hpp"
#include "drench/drench.hpp"
#include "pipeline/pipeline.hpp"
#include "state/saturation.hpp"

namespace drench {

namespace {

/// A scene that was made in code, checked as if it had come from a file. Its resolved form says all of it.
Scene checked(const Scene& scene) {
  Scene same = parse_scene(to_yaml(scene), scene.path.empty() ? "scene" : scene.path);
  same.path = scene.path;
  return same;
}

}  // namespace

struct Simulation::Parts {
  explicit Parts(const Scene& scene)
      : setup(build(checked(scene), memory_budget())),
        backend(make_kokkos_backend(setup.model)),
        pipeline(setup.model, *backend, setup.state) {
    setup.state = HostState();  // the backend has it
  }
  Setup setup;
  std::unique_ptr<Backend> backend;
  Pipeline pipeline;
};

Simulation::Simulation(const Scene& scene) : parts_(std::make_unique<Parts>(scene)) {}
Simulation::~Simulation() = default;

StepReport Simulation::step(double longest) {
  if (!(longest > 0)) throw std::invalid_argument("Simulation::step: a step has to be longer than 0 s");
  return parts_->pipeline.step(longest);
}

void Simulation::run_until(double time) {
  const double rounding = 1e-6 * parts_->setup.model.scene.time.step;
  while (this->time() < time - rounding) step(time - this->time());
}

double Simulation::time() const { return parts_->pipeline.time(); }
std::int64_t Simulation::steps() const { return parts_->pipeline.step_index(); }

HostState Simulation::state() const {
  HostState state = parts_->backend->download();
  parts_->pipeline.mark(state);
  return state;
}

std::vector<double> Simulation::saturation(const HostState& state) const {
  return node_saturation(parts_->setup.model, state);
}

const std::vector<std::array<Index, 3>>& Simulation::triangles() const { return parts_->setup.model.mesh.triangle; }
double Simulation::quantum() const { return parts_->setup.model.quantum; }
const std::vector<std::string>& Simulation::warnings() const { return parts_->setup.warnings; }

}  // namespace drench
