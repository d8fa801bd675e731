// The graph in real time: blocks come at their time, whatever the machine does; a run ends in
// order.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::test {
namespace {

using WallClock = std::chrono::steady_clock;

TEST(RealTime, KeepsTimeAndEndsInOrder) {
  ros::NodeHandle handle;
  std::vector<std::uint64_t> sequences;
  WallClock::time_point first;
  WallClock::time_point last;
  bool ended = false;
  std::uint64_t last_sequence = 0;
  const boost::function<void(const ring_gyro::OrbitalElements::ConstPtr&)> collect =
      [&](const ring_gyro::OrbitalElements::ConstPtr& message) {
        last = WallClock::now();
        if (sequences.empty()) first = last;
        sequences.push_back(message->sequence);
        EXPECT_FALSE(message->header.stamp.isZero());
      };
  const boost::function<void(const ring_gyro::EndOfRun::ConstPtr&)> end =
      [&](const ring_gyro::EndOfRun::ConstPtr& message) {
        ended = true;
        last_sequence = message->last_sequence;
      };
  // One subscription to each that the run waits for; their contents are tested elsewhere.
  const auto nothing = [](const auto&) {};
  const boost::function<void(const ring_gyro::ControlGains::ConstPtr&)> gains = nothing;
  const boost::function<void(const ring_gyro::ParameterEstimate::ConstPtr&)> estimates = nothing;
  const boost::function<void(const ring_gyro::PlantTruth::ConstPtr&)> truth = nothing;
  std::vector<ros::Subscriber> subscribers{
      handle.subscribe<ring_gyro::OrbitalElements>(bridge::topics::kOrbitalElements, 0, collect),
      handle.subscribe<ring_gyro::EndOfRun>(bridge::topics::kEndOfRun, 0, end),
      handle.subscribe<ring_gyro::ControlGains>(bridge::topics::kControlGains, 0, gains),
      handle.subscribe<ring_gyro::ParameterEstimate>(bridge::topics::kParameterEstimate, 0,
                                                     estimates),
      handle.subscribe<ring_gyro::PlantTruth>(bridge::topics::kPlantTruth, 0, truth)};
  const auto give_up = WallClock::now() + std::chrono::seconds(60);
  const auto complete = [&] { return ended && sequences.size() > last_sequence; };
  while (!complete() && WallClock::now() < give_up) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(ended);
  EXPECT_EQ(last_sequence, 2999u);
  ASSERT_EQ(sequences.size(), 3000u);
  for (std::size_t i = 0; i < sequences.size(); ++i) ASSERT_EQ(sequences[i], i);
  // Never fast; how late depends on what else the machine has to do.
  EXPECT_GT(std::chrono::duration<double>(last - first).count(), 2.5);
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "real_time_test");
  return RUN_ALL_TESTS();
}
