// Frames written beside the run: the same files as without a thread, and its errors.

#include "output/frame_queue.hpp"

#include <gtest/gtest.h>

#include <map>

#include "frame_reader.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "setup/build.hpp"

namespace drench::test {
namespace {

constexpr const char* block = R"(drench: 1
fluid: {spacing: 0.02, sources: [{block: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]}
cloth: [{mesh: {grid: {size: [0.2, 0.2], nodes: [6, 6]}}}]
bodies: [{sphere: {center: [0, -1, 0], radius: 0.2}}]
)";

drench::Setup example() { return build(parse_scene(block, "test.yaml")); }

/// The set-up, moved a little further with each frame.
HostState state_of(const HostState& initial, int frame) {
  HostState s = initial;
  s.time = 0.1 * frame;
  for (Vec3& x : s.fluid_position) x[1] -= 0.01 * frame;
  return s;
}

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
  return files;
}

}  // namespace

TEST(FrameQueue, WritesTheSameBytesAsTheWriterAlone) {
  const TempFolder with, without;
  const drench::Setup setup = example();
  FrameQueue queue(with.path(), setup.model);
  FrameWriter writer(without.path(), setup.model);
  for (int f = 0; f < 6; ++f) {
    queue.write(state_of(setup.state, f));
    queue.check();
    writer.write(state_of(setup.state, f));
  }
  queue.finish();
  EXPECT_EQ(queue.frames(), 6);
  EXPECT_EQ(queue.collections(), writer.collections());
  const auto files = files_in(with.path());
  EXPECT_EQ(files.size(), 2 * 6 + 1 + 3 + 1u) << "frames of liquid and cloth, the sphere, three collections, energies";
  EXPECT_TRUE(files == files_in(without.path()));
}

TEST(FrameQueue, WritesWhatItWasGivenBeforeItGoes) {
  const TempFolder folder;
  const drench::Setup setup = example();
  {
    FrameQueue queue(folder.path(), setup.model);
    for (int f = 0; f < 3; ++f) queue.write(state_of(setup.state, f));
  }
  const auto frames = read_collection(folder.path() / "fluid.pvd");
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(read_frame(folder.path() / frames[2].file)->GetNumberOfPoints(), setup.state.fluid_count());
}

TEST(FrameQueue, CollectionsNameOnlyFramesThatAreThere) {
  const TempFolder folder;
  const drench::Setup setup = example();
  FrameQueue queue(folder.path(), setup.model);
  std::size_t most = 0;
  for (int f = 0; f < 5; ++f) {
    queue.write(state_of(setup.state, f));
    if (!fs::exists(folder.path() / "fluid.pvd")) continue;  // while it writes
    const auto frames = read_collection(folder.path() / "fluid.pvd");
    for (const auto& frame : frames) EXPECT_TRUE(fs::exists(folder.path() / frame.file));
    most = std::max(most, frames.size());
  }
  queue.finish();
  EXPECT_GE(most, 3U) << "at most one frame is on its way";
}

TEST(FrameQueue, ErrorsComeOutOnceAndNoFrameIsCountedTwice) {
  const TempFolder folder;
  const drench::Setup setup = example();
  FrameQueue queue(folder.path(), setup.model);
  queue.write(state_of(setup.state, 0));
  queue.wait();
  fs::remove_all(folder.path() / "frames");
  write_text(folder.path() / "frames", "a file in the folder's place");
  queue.write(state_of(setup.state, 1));
  EXPECT_THROW(queue.wait(), std::exception);
  EXPECT_NO_THROW(queue.check());
  queue.write(state_of(setup.state, 2));
  EXPECT_THROW(queue.finish(), std::exception);
  EXPECT_EQ(read_collection(folder.path() / "fluid.pvd").size(), 1U);
}

}  // namespace drench::test
