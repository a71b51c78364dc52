#pragma once
// A run of a scene on the Kokkos backend whose stages are watched one by one.

#include <memory>

#include "pipeline/pipeline.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench::test {

struct StageRun {
  drench::Setup setup;
  std::unique_ptr<Backend> backend;
  std::vector<Stage> stages;
  double time = 0;  // s
  std::int64_t steps = 0;

  explicit StageRun(const std::string& yaml)
      : setup(build(parse_scene(yaml, "validation.yaml"))),
        backend(make_kokkos_backend(setup.model)),
        stages(stages_for(setup.model)) {
    backend->upload(setup.state);
  }

  /// One step of the scene's fixed Δt; calls around(stage, false) before and around(stage, true) after each stage.
  template <class Around>
  void step(Around&& around) {
    StepReport report;
    const StepInfo info{steps, time, setup.model.scene.time.step};
    for (const Stage stage : stages) {
      around(stage, false);
      backend->run(stage, info, report);
      around(stage, true);
    }
    time += info.dt;
    ++steps;
  }
};

}  // namespace drench::test
