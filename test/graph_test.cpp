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

#include "message_bytes.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro {
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
  Collector<ring_gyro_msgs::OrbitalElements> elements(handle, topics::kOrbitalElements);
  Collector<ring_gyro_msgs::ControlGains> gains(handle, topics::kControlGains);
  Collector<ring_gyro_msgs::ParameterEstimate> estimates(handle, topics::kParameterEstimate);
  Collector<ring_gyro_msgs::CompensationGains> decisions(handle, topics::kCompensationGains);
  Collector<ring_gyro_msgs::EndOfRun> ends(handle, topics::kEndOfRun);
  Collector<ring_gyro_msgs::PlantTruth> truths(handle, topics::kPlantTruth);

  const NodeConfiguration configuration = readNodeConfiguration(ros::NodeHandle("control_loops"));
  const LoopConfiguration& loop_configuration = configuration.loop;
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

  ClosedLoop loop(loop_configuration);
  ring_gyro_msgs::OrbitalElements elements_message;
  ring_gyro_msgs::ControlGains gains_message;
  ring_gyro_msgs::ParameterEstimate estimate_message;
  ring_gyro_msgs::CompensationGains decision_message;
  ring_gyro_msgs::PlantTruth truth_message;
  ParameterEstimate last;
  for (std::size_t block = 0; block < blocks; ++block) {
    const LoopRecord record = loop.step();
    toMessage(record.loops.elements, elements_message);
    elements.expectNext(elements_message);
    toMessage(record.loops.gains, gains_message);
    gains.expectNext(gains_message);
    toMessage(record.truth(), truth_message);
    truths.expectNext(truth_message);
    if (!record.estimate) continue;
    last = *record.estimate;
    toMessage(last, record.identifier.covariance(), estimate_message);
    estimates.expectNext(estimate_message);
    if (!compensated) continue;
    toMessage(*record.decision, estimate_message.header.stamp, decision_message);
    decisions.expectNext(decision_message);
  }
  EXPECT_EQ(estimates.compared(), periods);

  // And what it computes is the device.
  const ResonatorParameters& device = loop_configuration.plant.resonator;
  EXPECT_TRUE(last.converged);
  EXPECT_NEAR(last.value[kGamma1], device.gamma1, 1e-4);
  EXPECT_NEAR(last.value[kGamma2], device.gamma2, 1e-4);
  EXPECT_NEAR(last.value[kMu1], device.mu1, 5e-8);
  EXPECT_NEAR(last.value[kMu2], device.mu2, 5e-8);
  EXPECT_NEAR(last.value[kDriveGain] / device.driveGain(), 1.0, 5e-4);
  EXPECT_TRUE(elements.messages().back()->status.amplitude_locked);
  EXPECT_EQ(last.lost_blocks, 0u);
  if (compensated) {
    EXPECT_EQ(decisions.messages().back()->state, ring_gyro_msgs::CompensationGains::TRACKING);
    EXPECT_LT(std::hypot(last.residual_gamma1, last.residual_gamma2), 1e-3);
  }
}

}  // namespace
}  // namespace ring_gyro

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "graph_test");
  return RUN_ALL_TESTS();
}
