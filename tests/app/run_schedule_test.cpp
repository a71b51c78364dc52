// When frames and checkpoints are due.

#include "output/run_schedule.hpp"

#include <gtest/gtest.h>

namespace drench::test {
namespace {

RunSchedule schedule(double every, double checkpoint_every, double end = 1) {
  Scene scene;
  scene.time.step = 0.01;
  scene.time.end = end;
  scene.output.every = every;
  scene.output.checkpoint_every = checkpoint_every;
  return RunSchedule(scene);
}

}  // namespace

TEST(RunSchedule, StepsEndAtFramesAndAtTheEnd) {
  RunSchedule s = schedule(0.3, 0);
  EXPECT_TRUE(s.frame_due(0));
  s.frame_taken();
  EXPECT_FALSE(s.frame_due(0));
  EXPECT_DOUBLE_EQ(s.time_left(0), 0.3);
  EXPECT_TRUE(s.frame_due(0.3 - 1e-9));  // less than the rounding before its time
  for (int k = 0; k < 3; ++k) s.frame_taken();
  EXPECT_NEAR(s.time_left(0.95), 0.05, 1e-15);  // the next frame would be at 1.2 s
  EXPECT_TRUE(s.clipped_by_end(0.95, 1 - 0.95));
  EXPECT_TRUE(s.clipped_by_end(0.95, 0.5 * (1 - 0.95)));
  EXPECT_FALSE(s.clipped_by_end(0.95, 0.01));
  EXPECT_FALSE(s.ended(0.999));
  EXPECT_TRUE(s.ended(1 - 1e-9));
}

TEST(RunSchedule, AFrameAtTheEndIsNoClip) {
  RunSchedule s = schedule(0.5, 0);
  s.frame_taken();
  s.frame_taken();
  EXPECT_FALSE(s.clipped_by_end(0.99, 1 - 0.99));
}

TEST(RunSchedule, WithoutFramesNoneIsDue) {
  const RunSchedule s = schedule(0, 0);
  EXPECT_FALSE(s.has_frames());
  EXPECT_FALSE(s.frame_due(0.5));
  EXPECT_FALSE(s.checkpoint_due(0.5));
  EXPECT_DOUBLE_EQ(s.time_left(0.25), 0.75);
}

TEST(RunSchedule, GoesOnAfterTheFramesThatThereAre) {
  RunSchedule at = schedule(0.1, 0), between = schedule(0.1, 0);
  EXPECT_TRUE(at.go_on(0.3));  // 0.1 + 0.1 + 0.1 is more than 0.3
  EXPECT_NEAR(at.time_left(0.3), 0.1, 1e-15);
  EXPECT_FALSE(between.go_on(0.35));
  EXPECT_NEAR(between.time_left(0.35), 0.05, 1e-15);
}

TEST(RunSchedule, CheckpointsComeAtMultiplesOfTheirInterval) {
  RunSchedule s = schedule(0, 0.25);
  s.plan_checkpoint(0);
  EXPECT_FALSE(s.checkpoint_due(0.2));
  EXPECT_TRUE(s.checkpoint_due(0.26));
  s.plan_checkpoint(0.26);
  EXPECT_FALSE(s.checkpoint_due(0.49));
  EXPECT_TRUE(s.checkpoint_due(0.5));
}

TEST(RunSchedule, HoldsAnyInterval) {
  RunSchedule tiny = schedule(0, 1e-300), huge = schedule(0, 1e300);
  tiny.plan_checkpoint(0.5);
  huge.plan_checkpoint(0.5);
  EXPECT_TRUE(tiny.checkpoint_due(0.5));
  EXPECT_FALSE(huge.checkpoint_due(1e6));
}

}  // namespace drench::test
