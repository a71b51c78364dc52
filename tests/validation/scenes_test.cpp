// Every scene of scenes/: the ledger, the bounds of saturation, and how often the liquid's solves end at their cap.
// (Whole runs of single scenes: scene_run_test.)

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "paths.hpp"
#include "pipeline/pipeline.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

constexpr int most_steps = 60;

std::vector<std::string> scene_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(scenes_folder()))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

struct Worst {
  double ledger = 0;     // quanta
  double float_sum = 0;  // 1: of the ledger's mass
  double excess = 0;     // 1: saturation above s_max
  Quanta least = 0;      // quanta on a node
  double capped = 0;     // 1: share of the steps
};

Worst run(const std::string& file) {
  const drench::Setup setup = build(load_scene(file));
  const Model& m = setup.model;
  double most = 0;
  for (const ClothMaterial& c : m.cloths)
    if (c.porous) most = std::max(most, c.max_saturation);
  const auto backend = make_kokkos_backend(m);
  Pipeline pipeline(m, *backend, setup.state);
  Worst worst;
  int capped = 0, steps = 0;
  const double end = m.scene.time.end;
  while (steps < most_steps && pipeline.time() < end - 1e-9) {
    const StepReport r = pipeline.step(end - pipeline.time());
    ++steps;
    capped += !r.density_converged || !r.divergence_converged;
    worst.ledger = std::max(worst.ledger, std::fabs(double(r.mass_total() - pipeline.initial_total())));
    const double account = double(r.mass_fluid + r.mass_cloth) * m.quantum;
    if (account > 0) worst.float_sum = std::max(worst.float_sum, std::fabs(r.mass_float - account) / account);
    if (m.has_porous()) worst.excess = std::max(worst.excess, r.saturation_max - most);
  }
  worst.capped = double(capped) / steps;
  for (const Quanta liquid : backend->download().node_liquid) worst.least = std::min(worst.least, liquid);
  return worst;
}

}  // namespace

TEST(scenes, ledger_bounds_and_convergence_of_each) {
  const auto files = scene_files();
  ASSERT_GE(files.size(), 10u);
  Worst all;
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const Worst w = run(file);
    EXPECT_EQ(w.ledger, 0);
    EXPECT_LE(w.float_sum, 1e-6);
    EXPECT_LE(w.excess, 0);
    EXPECT_GE(w.least, 0);
    EXPECT_LE(w.capped, 0.01);
    all = {std::max(all.ledger, w.ledger), std::max(all.float_sum, w.float_sum), std::max(all.excess, w.excess),
           std::min(all.least, w.least), std::max(all.capped, w.capped)};
  }
  const std::string name = fmt::format("{} scenes, the first {} steps of each: ", files.size(), most_steps);
  report({name + "mass budget", "constant", all.ledger, 0, "quanta"});
  report({name + "independent floating-point sum", "mass budget", all.float_sum, 1e-6});
  report({name + "saturation above s_max", "0", all.excess, 0});
  report({name + "liquid missing on a node", "0", double(-all.least), 0, "quanta"});
  report({name + "steps that end at max_iterations (worst scene)", "1 %", all.capped, 0.01});
}

}  // namespace drench::test
