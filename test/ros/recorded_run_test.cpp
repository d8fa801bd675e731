// A recorded run comes back as it was: every pair, the truth, the rotation of the case.

#include "ring_gyro/ros/recorded_run.h"

#include <gtest/gtest.h>

#include "ros/bag_fixture.h"

namespace ring_gyro::test {
namespace {

cvg::LoopConfiguration turned() {
  cvg::LoopConfiguration configuration =
      cvg::readConfigurationFile(RING_GYRO_CONFIG_DIR "/paper_simulation.yaml", {});
  configuration.run.duration = 2.0;
  configuration.plant.rotation.rate = 0.25;
  return configuration;
}

TEST(RecordedRun, HoldsEveryPairWithItsRotation) {
  const TemporaryFolder folder;
  recordRun(turned(), folder.file("run.bag"));
  const bridge::RecordedRun run = bridge::readRecordedRun({folder.file("run.bag")});
  ASSERT_EQ(run.pairs.size(), 2000u);
  for (std::size_t n = 0; n < run.pairs.size(); ++n) {
    const bridge::RecordedPair& pair = run.pairs[n];
    ASSERT_EQ(pair.elements.stamp.sequence, n);
    ASSERT_EQ(pair.gains.stamp.sequence, n);
    ASSERT_DOUBLE_EQ(pair.rotation_rate, 0.25);
  }
  ASSERT_TRUE(run.truth);
  EXPECT_DOUBLE_EQ(run.truth->gamma1, turned().plant.resonator.gamma1);
}

TEST(RecordedRun, HoldsThePartThatWasAskedFor) {
  const TemporaryFolder folder;
  recordRun(turned(), folder.file("run.bag"));
  const bridge::RecordedRun run = bridge::readRecordedRun({folder.file("run.bag")}, {}, 0.5, 1.0);
  EXPECT_NEAR(static_cast<double>(run.pairs.size()), 1000.0, 2.0);
  EXPECT_NEAR(static_cast<double>(run.pairs.front().elements.stamp.sequence), 500.0, 2.0);
}

TEST(RecordedRun, SaysWhatIsWrong) {
  EXPECT_THROW(bridge::readRecordedRun({}), bridge::BagError);
  EXPECT_THROW(bridge::readRecordedRun({"/nowhere/run.bag"}), bridge::BagError);
}

}  // namespace
}  // namespace ring_gyro::test
