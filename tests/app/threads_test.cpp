// The same scene with one, two and three threads, and scenes on the reference: the program as a user starts it.

#include <gtest/gtest.h>
#include <sys/auxv.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>

#include "base/free_cores.hpp"
#include "pipeline/runtime.hpp"
#include "run_program.hpp"

namespace drench::test {
namespace {

std::map<std::string, std::string> frames(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".vtu") files[entry.path().filename().string()] = read_text(entry.path());
  }
  return files;
}

/// Water lands on a sheet that is wet on one side: it is absorbed on the other, and the wet side drips at once.
constexpr const char* landing_scene = R"(drench: 1
time: {step: 0.004, end: 0.5, mode: cfl}
domain: {min: [-0.4, -0.4, -0.4], max: [0.4, 0.6, 0.4]}
output: {every: 0.02}
fluid:
  spacing: 0.02
  viscosity: 1.0e-4
  sources:
    - block: {min: [-0.1, 0.02, -0.1], max: [0.1, 0.14, 0.1], velocity: [0, -0.5, 0]}
cloth:
  - name: sheet
    mesh: {grid: {size: [0.4, 0.4], nodes: [16, 16]}}
    thickness: 0.004
    stretch: 2000
    damping: 200
    pin: [{edges: true}]
    initial_saturation: [{box: {min: [-0.2, -1, -0.2], max: [0.0, 1, 0.2]}, value: 1.15}]
    porous: {solid_fraction: 0.4, absorption: 0.02, diffusivity: 1.0e-3, emission_velocity: 5}
)";

std::string scene(const std::string& name) { return scenes_folder() + "/" + name; }

}  // namespace

TEST(threads, one_two_and_three_threads_write_the_same_bytes) {
  const TempFolder folder;
  write_text(folder.path() / "scene.yaml", landing_scene);
  for (const std::string threads : {"1", "2", "3"}) {
    const Outcome o =
        run_drench(folder.path(), {"run", "scene.yaml", "--quiet", "--threads", threads, "-o", "threads" + threads});
    ASSERT_EQ(o.code, 0) << o.err;
    const std::string log = read_text(folder.path() / ("threads" + threads) / "run.log");
    if (log.find("backend: OpenMP") != std::string::npos) {
      EXPECT_NE(log.find("threads: " + threads + "\n"), std::string::npos)
          << "or one thread would be compared with one";
    }
  }
  // The scene has to reach the stages whose order of operations could depend on threads.
  const Table table = read_table(folder.path() / "threads1" / "stats.csv");
  const std::size_t last = table.rows.size() - 1;
  double most_particles = 0, collisions = 0;
  for (std::size_t row = 0; row <= last; ++row) {
    most_particles = std::max(most_particles, table.number(row, "particles"));
    collisions += table.number(row, "collisions");
  }
  EXPECT_GT(most_particles, table.number(0, "particles") + 40);                      // emitted: there are no jets
  EXPECT_GT(table.number(last, "mass_cloth"), table.number(0, "mass_cloth") + 0.1);  // kg: absorbed
  EXPECT_GT(table.number(last, "mass_drained"), 0.1);                                // kg: left the domain
  EXPECT_GT(collisions, 100);

  const auto one = frames(folder.path() / "threads1");
  ASSERT_EQ(one.size(), 2 * 26u);  // liquid and cloth, 0 to 0.5 s every 0.02 s
  for (const char* other : {"threads2", "threads3"}) {
    const auto files = frames(folder.path() / other);
    ASSERT_EQ(one.size(), files.size()) << other;
    for (const auto& [name, bytes] : one) EXPECT_TRUE(files.at(name) == bytes) << other << ": " << name << " differs";
  }
}

TEST(threads, are_as_many_as_there_are_free_cores) {
  EXPECT_EQ(threads_for(2.0, 2), 2);
  EXPECT_EQ(threads_for(1.8, 2), 2);
  EXPECT_EQ(threads_for(1.5, 2), 1);  // another program on one of them
  EXPECT_EQ(threads_for(0.3, 2), 1);
  EXPECT_EQ(threads_for(6.9, 8), 7);
  EXPECT_EQ(threads_for(9.0, 8), 8);
  const double free = free_cores();
  EXPECT_GT(free, 0);
  EXPECT_LE(free, allowed_cores() + 0.1);
}

TEST(threads, keep_to_the_quota_of_a_control_group) {
  EXPECT_EQ(quota_cores("150000 100000"), 1.5);
  EXPECT_EQ(quota_cores("max 100000"), 0);
  EXPECT_EQ(quota_cores(""), 0);
}

TEST(threads, tell_another_program_from_their_own_work) {
  using namespace std::chrono;
  const auto spin = [](milliseconds span) {
    for (const auto begin = steady_clock::now(); steady_clock::now() < begin + span;) {
    }
  };
  OtherPrograms others;
  spin(milliseconds(300));
  const std::optional<double> beside_own = others.busy_cores();
  if (!beside_own) GTEST_SKIP() << "this machine does not tell";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    spin(milliseconds(600));
    _exit(0);
  }
  usleep(300000);
  const std::optional<double> beside_child = others.busy_cores();
  waitpid(child, nullptr, 0);
  EXPECT_LE(*beside_own, allowed_cores() - 0.3);
  EXPECT_GE(*beside_child, 0.3);
}

/// OpenMP's runtime tells what it was given each time that the program starts.
TEST(threads, settle_in_a_program_that_starts_itself_anew_once) {
  if (!computes_on_host() || allowed_cores() == 1) GTEST_SKIP() << "there is nothing to settle";
  if (getauxval(AT_BASE) == 0)
    GTEST_SKIP() << "in a pack, where the dynamic loader runs the program, it does not start anew";
  const TempFolder folder;
  const auto started = [&](const std::vector<std::string>& arguments) {
    const Outcome o = run_drench(folder.path(), arguments);
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_NE(o.out.find("version: "), std::string::npos);
    int times = 0;
    for (std::size_t at = o.err.find("OMP_WAIT_POLICY"); at != std::string::npos;
         at = o.err.find("OMP_WAIT_POLICY", at + 1))
      ++times;
    return std::pair(times, o.err.substr(std::max(std::size_t{1}, o.err.rfind("DISPLAY ENVIRONMENT BEGIN")) - 1));
  };
  const std::string policy = std::getenv("OMP_WAIT_POLICY") ? std::getenv("OMP_WAIT_POLICY") : "";
  setenv("OMP_DISPLAY_ENV", "true", 1);
  unsetenv("OMP_WAIT_POLICY");
  const auto [twice, settled] = started({"info", "--threads", "2"});
  const auto [once, single] = started({"info", "--threads", "1"});
  setenv("OMP_WAIT_POLICY", "passive", 1);
  const auto [as_given, given] = started({"info", "--threads", "2"});
  unsetenv("OMP_DISPLAY_ENV");
  if (policy.empty()) unsetenv("OMP_WAIT_POLICY");
  if (once == 0) GTEST_SKIP() << "this OpenMP tells nothing";
  EXPECT_EQ(twice, 2);
  EXPECT_NE(settled.find("OMP_NUM_THREADS = '2'"), std::string::npos) << settled;
  EXPECT_EQ(once, 1);
  EXPECT_EQ(as_given, 1);
}

TEST(reference, runs_the_small_scenes_through_the_same_pipeline) {
  for (const char* name : {"cloth_only.yaml", "dam_break.yaml", "wick.yaml"}) {
    const TempFolder folder;
    const Outcome o = run_drench(
        folder.path(), {"run", scene(name), "--backend", "reference", "--steps", "10", "--quiet", "-o", "out"});
    ASSERT_EQ(o.code, 0) << name << ": " << o.err;
    const Table table = read_table(folder.path() / "out" / "stats.csv");
    EXPECT_EQ(table.rows.size(), 10u) << name;
    for (std::size_t row = 0; row < table.rows.size(); ++row) EXPECT_EQ(table.number(row, "mass_error"), 0.0) << name;
  }
}

}  // namespace drench::test
