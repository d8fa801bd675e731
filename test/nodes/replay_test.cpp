// A recorded run, replayed to the identifier's node, gives the estimates of the run bit by bit.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/loop_recorder.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/ros/topics.h"
#include "ros/message_bytes.h"

namespace ring_gyro::test {
namespace {

using Estimate = ring_gyro::ParameterEstimate;

TEST(Replay, GivesTheEstimatesOfTheRun) {
  cvg::LoopConfiguration configuration =
      bridge::readNodeConfiguration(ros::NodeHandle("ekf_identifier")).loop;
  const std::string bag = ::testing::TempDir() + "ring_gyro_replay_test.bag";
  std::vector<std::vector<std::uint8_t>> expected;
  {
    cvg::ClosedLoop loop(configuration);
    bridge::LoopRecorder recorder(bag, false);
    cvg::BlockStamp last;
    for (std::uint64_t i = 0; i < configuration.run.blocks(configuration.converter); ++i) {
      const cvg::LoopRecord record = loop.step();
      recorder.write(record);
      last = record.displacement.stamp;
      if (!record.estimate) continue;
      Estimate message;
      bridge::toMessage(*record.estimate, message);
      expected.push_back(bytesOf(message));
    }
    recorder.finish(last);
  }

  ros::NodeHandle handle;
  std::vector<std::vector<std::uint8_t>> received;
  const boost::function<void(const Estimate::ConstPtr&)> collect =
      [&](const Estimate::ConstPtr& message) { received.push_back(bytesOf(*message)); };
  const ros::Subscriber subscriber =
      handle.subscribe<Estimate>(bridge::topics::kParameterEstimate, 0, collect);
  const std::string command = "rosbag play --quiet --queue=0 --wait-for-subscribers --rate=10 " +
                              bag +
                              " --topics orbital_elements control_gains end_of_run __name:=player";
  std::thread player([&] { EXPECT_EQ(std::system(command.c_str()), 0); });
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (received.size() < expected.size() && std::chrono::steady_clock::now() < give_up) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  player.join();
  std::remove(bag.c_str());
  ASSERT_EQ(received.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_TRUE(received[i] == expected[i]) << "estimate " << i;
  }
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "replay_test");
  return RUN_ALL_TESTS();
}
