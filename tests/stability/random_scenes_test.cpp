// Scenes drawn at random, 50 steps each, watched. DRENCH_RANDOM_SEED and DRENCH_RANDOM_COUNT go on from the ten of the
// suite: DRENCH_RANDOM_COUNT=300 drench_tests_stability --gtest_filter='random_scenes.*'

#include "random_scenes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <vector>

#include "hard_scene.hpp"
#include "scene/scene_error.hpp"
#include "setup/setup_error.hpp"

namespace drench::test {
namespace {

std::uint64_t from_environment_number(const char* name, std::uint64_t usual) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::stoull(text) : usual;
}

/// Does the program warn of a gain of energy? What starts inside a solid is put out, which brings some, and so may
/// liquid at cloth whose solve ends at its cap.
bool warns_of_energy(const std::string& yaml) {
  const std::vector<std::string> lines = setup_from(yaml).warnings;
  return std::any_of(lines.begin(), lines.end(), [](const std::string& l) {
    return l.find("out at once") != std::string::npos || l.find("pushing it out adds") != std::string::npos ||
           l.find("may gain energy") != std::string::npos;
  });
}

/// Slacks, from the step on in which a pressure solve ends at its cap: what holds in the worst of 6,000 scenes. By xpbd
/// the cloth in that solve is then far from solved, and there is no bound (docs/limitations.md).
double capped_energy(const RandomScene& drawn) {
  return drawn.yaml.find("method: xpbd") != std::string::npos ? HUGE_VAL : 20;
}

struct Outcome {
  int energies = 0;              // scenes in which it is watched
  double worst = 0, capped = 0;  // its largest excess in slacks, where all pressure solves converge and where not
  int capped_energies = 0, told = 0, stopped = 0;  // scenes
  void print(std::size_t scenes) const {
    std::printf(
        "%zu scenes, energy watched in %d of them: at most %.2g slacks above its bound, %.2g in %d whose pressure "
        "solves end at their cap; %d tell of passages, %d end with a failure\n",
        scenes, energies, worst, capped, capped_energies, told, stopped);
  }
};

Outcome watch_scenes(const std::vector<std::uint64_t>& seeds, bool narrow = false) {
  Outcome all;
  for (const std::uint64_t n : seeds) {
    const RandomScene drawn = SceneDraw(n, narrow).scene();
    SCOPED_TRACE(fmt::format("seed {}\n{}", n, drawn.yaml));
    try {
      const bool energy = drawn.closed && drawn.ordinary && !drawn.crowded && !warns_of_energy(drawn.yaml);
      WatchedRun run(drawn.yaml, {.told_passages = true,
                                  .may_stop = !drawn.ordinary || drawn.crowded,
                                  .bounded_saturation = drawn.bounded,
                                  .energy = energy ? 1 : HUGE_VAL,
                                  .capped_energy = capped_energy(drawn),
                                  .springs = !drawn.folds});
      run.steps(50);
      run.print(fmt::format("seed {}{}", n, drawn.ordinary ? "" : ", extreme").c_str());
      all.told += run.watch().told() > 0;
      all.stopped += !run.stopped().empty();
      if (!energy) continue;
      ++all.energies;
      all.capped_energies += run.watch().capped();
      double& most = run.watch().capped() ? all.capped : all.worst;
      most = std::max(most, run.watch().energy_excess());
    } catch (const SceneError& error) {
      ADD_FAILURE() << "refused: " << error.what();
    } catch (const SetupError& error) {
      ADD_FAILURE() << "refused at set-up: " << error.key << ": " << error.what();
    }
  }
  all.print(seeds.size());
  return all;
}

}  // namespace

TEST(random_scenes, hold_what_must_hold) {
  const std::uint64_t seed = from_environment_number("DRENCH_RANDOM_SEED", 1),
                      count = from_environment_number("DRENCH_RANDOM_COUNT", 10);
  std::vector<std::uint64_t> seeds(count);
  std::iota(seeds.begin(), seeds.end(), seed);
  const Outcome all = watch_scenes(seeds);
  if (count < 300) return;  // shares
  EXPECT_LE(all.told, 0.01 * static_cast<double>(count));
  EXPECT_LE(all.stopped, 0.01 * static_cast<double>(count));
}

TEST(random_scenes, that_broke_a_rule_once_hold_it) {
  // Two sheets that pass each other; a fold that closes on three particles; cloth whose solves end at their cap; a
  // plane that flies and turns, which took 2.8 s a step; a ball that starts inside the floor; liquid that swings in a
  // field. A reservoir whose cloth held buffered liquid; pins that throw the cloth between them by a lever, to 55 J and
  // to 343 m/s.
  EXPECT_EQ(watch_scenes({1019, 1025, 1027, 2008, 2042, 2087, 6016, 7024, 10634, 11751, 11401}, true).stopped, 0);
  // A particle that fabric lets out between it and a sheet of 464 times less mass a node, which went at 4,650 m/s.
  // Sheets on a plane whose relaxed nodes were not finite numbers any more, which counted as converged. Compressible
  // fabric with a porosity of 2e-8, which is 0 in single precision.
  EXPECT_EQ(watch_scenes({31515, 80114, 80362, 92036}).stopped, 0);
}

}  // namespace drench::test
