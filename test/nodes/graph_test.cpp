// Listens to a whole run of the graph and compares every message with the same loop in this
// process.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/simulation/closed_loop.h"
#include "ros/message_bytes.h"

namespace ring_gyro::test {
namespace {

template <typename Message>
class Collector {
 public:
  Collector(ros::NodeHandle& handle, const char* topic)
      : subscriber_(handle.subscribe<Message>(
            topic, 0,
            [this](const boost::shared_ptr<const Message>& message) {
              messages_.push_back(message);
            },
            ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay())) {}

  const std::vector<boost::shared_ptr<const Message>>& messages() const { return messages_; }
  void leave() { subscriber_.shutdown(); }

  /// Whether the next message in order is this one; says so only for the first that is not.
  void expectNext(const Message& expected) {
    if (compared_ < messages_.size() && mismatches_ == 0) {
      const bool same = bytesOf(*messages_[compared_]) == bytesOf(expected);
      EXPECT_TRUE(same) << "message " << compared_ << " of " << subscriber_.getTopic();
      if (!same) ++mismatches_;
    }
    ++compared_;
  }
  std::size_t compared() const { return compared_; }

 private:
  std::vector<boost::shared_ptr<const Message>> messages_;
  std::size_t compared_ = 0;
  std::size_t mismatches_ = 0;
  ros::Subscriber subscriber_;
};

TEST(Graph, SendsWhatTheLoopInOneProcessComputes) {
  ros::NodeHandle handle;
  Collector<ring_gyro::OrbitalElements> elements(handle, bridge::topics::kOrbitalElements);
  Collector<ring_gyro::ControlGains> gains(handle, bridge::topics::kControlGains);
  Collector<ring_gyro::ParameterEstimate> estimates(handle, bridge::topics::kParameterEstimate);
  Collector<ring_gyro::CompensationGains> decisions(handle, bridge::topics::kCompensationGains);
  Collector<ring_gyro::EndOfRun> ends(handle, bridge::topics::kEndOfRun);
  Collector<ring_gyro::PlantTruth> truths(handle, bridge::topics::kPlantTruth);

  const bridge::NodeConfiguration configuration =
      bridge::readNodeConfiguration(ros::NodeHandle("control_loops"));
  const cvg::LoopConfiguration& loop_configuration = configuration.loop;
  const std::size_t blocks = loop_configuration.run.blocks(loop_configuration.converter);
  const std::size_t periods = blocks / loop_configuration.periodBlocks();
  const bool compensated = loop_configuration.control.compensation;

  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(90);
  const auto complete = [&] {
    return !ends.messages().empty() && elements.messages().size() >= blocks &&
           gains.messages().size() >= blocks && truths.messages().size() >= blocks &&
           estimates.messages().size() >= periods &&
           (!compensated || decisions.messages().size() >= periods);
  };
  while (ros::ok() && !complete() && std::chrono::steady_clock::now() < give_up) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  elements.leave();
  gains.leave();
  estimates.leave();
  decisions.leave();
  ends.leave();
  truths.leave();

  ASSERT_EQ(ends.messages().size(), 1u);
  EXPECT_EQ(ends.messages()[0]->last_sequence, blocks - 1);
  ASSERT_EQ(elements.messages().size(), blocks);
  ASSERT_EQ(gains.messages().size(), blocks);
  ASSERT_EQ(truths.messages().size(), blocks);
  ASSERT_EQ(estimates.messages().size(), periods);
  ASSERT_EQ(decisions.messages().size(), compensated ? periods : 0);

  cvg::ClosedLoop loop(loop_configuration);
  ring_gyro::OrbitalElements elements_message;
  ring_gyro::ControlGains gains_message;
  ring_gyro::ParameterEstimate estimate_message;
  ring_gyro::CompensationGains decision_message;
  ring_gyro::PlantTruth truth_message;
  cvg::ParameterEstimate last;
  for (std::size_t block = 0; block < blocks; ++block) {
    const cvg::LoopRecord record = loop.step();
    bridge::toMessage(record.loops.elements, elements_message);
    elements.expectNext(elements_message);
    bridge::toMessage(record.loops.gains, gains_message);
    gains.expectNext(gains_message);
    bridge::toMessage(record.truth(), truth_message);
    truths.expectNext(truth_message);
    if (!record.estimate) continue;
    last = *record.estimate;
    bridge::toMessage(last, estimate_message);
    estimates.expectNext(estimate_message);
    if (!compensated) continue;
    bridge::toMessage(*record.decision, estimate_message.header.stamp, decision_message);
    decisions.expectNext(decision_message);
  }
  EXPECT_EQ(estimates.compared(), periods);

  // And what it computes is the device.
  const cvg::ResonatorParameters& device = loop_configuration.plant.resonator;
  EXPECT_TRUE(last.converged);
  EXPECT_NEAR(last.value[cvg::kGamma1], device.gamma1, 1e-4);
  EXPECT_NEAR(last.value[cvg::kGamma2], device.gamma2, 1e-4);
  EXPECT_NEAR(last.value[cvg::kMu1], device.mu1, 5e-8);
  EXPECT_NEAR(last.value[cvg::kMu2], device.mu2, 5e-8);
  EXPECT_NEAR(last.value[cvg::kDriveGain] / device.driveGain(), 1.0, 5e-4);
  EXPECT_TRUE(elements.messages().back()->status.amplitude_locked);
  EXPECT_EQ(last.lost_blocks, 0u);
  if (compensated) {
    EXPECT_EQ(decisions.messages().back()->state, ring_gyro::CompensationGains::TRACKING);
    EXPECT_LT(std::hypot(last.residual_gamma1, last.residual_gamma2), 1e-3);
  }
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "graph_test");
  return RUN_ALL_TESTS();
}
