// A checkpoint's file: every bit of a state, and which scenes may go on from it. Runs that go on: restart_test.cpp.

#include "output/checkpoint.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "base/version.hpp"
#include "good_scenes.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "scene/scene_difference.hpp"

namespace drench::test {
namespace {

using Words = std::vector<std::string>;

TEST(CheckpointFile, KeepsEveryBitAndNamesOtherVersions) {
  const TempFolder folder;
  const fs::path path = folder.path() / checkpoint_name(12);
  Checkpoint c;
  c.version = version_string;
  c.scene = "drench: 1\n";
  c.frames = 3;
  c.state.step = 12;
  c.state.time = 0.1 + 0.2;
  c.state.fluid_position = {{-0.0, 1e-310, std::nextafter(1.0, 2.0)}};
  c.state.fluid_mass = {-5};
  c.state.fluid_origin = {2};
  c.state.body_orientation = {{1, 2, 3, 4}};
  c.state.jet_particles = {9, 10};
  c.state.next_id = std::int64_t{1} << 40;
  write_checkpoint(path, c);
  const Checkpoint back = read_checkpoint(path);
  EXPECT_EQ(back.scene, c.scene);
  EXPECT_EQ(back.frames, 3);
  EXPECT_EQ(back.state.time, c.state.time);
  using Bits = std::array<std::uint64_t, 3>;
  EXPECT_EQ(std::bit_cast<Bits>(back.state.fluid_position[0]), std::bit_cast<Bits>(c.state.fluid_position[0]));
  EXPECT_EQ(back.state.fluid_mass, c.state.fluid_mass);
  EXPECT_EQ(back.state.fluid_origin, c.state.fluid_origin);
  EXPECT_EQ(back.state.body_orientation, c.state.body_orientation);
  EXPECT_EQ(back.state.jet_particles, c.state.jet_particles);
  EXPECT_EQ(back.state.next_id, c.state.next_id);
  EXPECT_TRUE(back.state.node_position.empty());
  c.version = "0.0.9";
  write_checkpoint(path, c);
  try {
    read_checkpoint(path);
    FAIL() << "another version";
  } catch (const CheckpointError& e) {
    EXPECT_EQ(e.what(),
              fmt::format("{}: was written by version 0.0.9, this drench is {}", path.string(), version_string));
  }
  EXPECT_THROW(write_checkpoint(folder.path() / "nowhere" / "c.drench", c), std::runtime_error);
  EXPECT_EQ(names_in(folder.path()), (Words{"checkpoint_000012.drench"}));
}

TEST(CheckpointFile, NamesAreInOrderOfTheirSteps) {
  const TempFolder folder;
  for (const char* name : {"checkpoint_000009.drench", "checkpoint_1000000.drench", "checkpoint_999999.drench",
                           "checkpoint_1.drench", "checkpoint_000010.drench.bak", ".checkpoint_000011.drench.part"})
    write_text(folder.path() / name, "");
  Words names;
  for (const auto& path : checkpoints_in(folder.path())) names.push_back(path.filename().string());
  EXPECT_EQ(names, (Words{"checkpoint_1000000.drench", "checkpoint_999999.drench", "checkpoint_000009.drench"}));
}

TEST(SceneDifference, NamesTheFirstKey) {
  const std::string text = drench::testing::everything;
  const auto swapped = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    const auto at = other.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from);
    return scene_difference(text, other.replace(at, from.size(), to), resumable_keys).value_or("none");
  };
  EXPECT_EQ(swapped("", ""), "none");
  EXPECT_EQ(swapped("end: 3.5", "end: 4"), "none");
  EXPECT_EQ(swapped("every: 0.05, checkpoint_every: 0.7", "every: 1, checkpoint_every: 2"), "none");
  EXPECT_EQ(swapped("file: exists.obj", "file: /elsewhere/exists.obj"), "none") << "its geometry counts, not its name";
  EXPECT_EQ(swapped("step: 0.002", "step: 0.001"), "time.step was 0.002, is 0.001");
  EXPECT_EQ(swapped("gravity: [0.1, -1.62, 0.2]", "gravity: [0.1, -1.62, 0.3]"),
            "gravity was [0.1, -1.62, 0.2], is [0.1, -1.62, 0.3]");
  EXPECT_EQ(swapped("strain_limit: 0.05\n", "strain_limit: 0.06\n"), "cloth.0.strain_limit was 0.05, is 0.06");
  EXPECT_EQ(swapped(", end: 1.5}", "}"), "fluid.sources.6.jet.end was 1.5 and is not given now");
  EXPECT_EQ(swapped("density: 998\n", "density: 998\n  x: 5\n"), "fluid.x was not given and is 5 now");
}

}  // namespace
}  // namespace drench::test
