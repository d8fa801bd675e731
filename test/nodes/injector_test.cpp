// The injector's node: one decision for each estimate, and its services.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::test {
namespace {

using Decision = ring_gyro::CompensationGains;
using Estimate = ring_gyro::ParameterEstimate;

class InjectorTest : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kPeriod = 100;  // blocks

  void SetUp() override {
    publisher_ = handle_.advertise<Estimate>(bridge::topics::kParameterEstimate, 0);
    const boost::function<void(const Decision::ConstPtr&)> collect =
        [this](const Decision::ConstPtr& message) { decisions_.push_back(*message); };
    subscriber_ = handle_.subscribe<Decision>(bridge::topics::kCompensationGains, 0, collect);
    waitFor([this] { return publisher_.getNumSubscribers() > 0; });
  }

  template <typename Condition>
  static void waitFor(Condition condition) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!condition() && std::chrono::steady_clock::now() < give_up) {
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_TRUE(condition());
  }

  /// The decision on a good estimate of gamma = (0.02, 0.03).
  Decision decide() {
    ++estimates_;
    Estimate estimate;
    estimate.header.stamp = ros::Time(1 + estimates_);
    estimate.session = 1;
    estimate.last_sequence = estimates_ * kPeriod - 1;
    estimate.duration = 1000000;
    estimate.used_blocks = estimates_ * kPeriod;
    estimate.updated = true;
    estimate.value = {1.0, 0.0, 0.02, 0.03, 0.0, 0.0, 1.1e5};
    for (int i = 0; i < 7; ++i) estimate.covariance[8 * i] = 1e-12;
    estimate.covariance[48] = 1.0;
    estimate.angle_covered = 10.0;
    estimate.converged = true;
    const std::size_t before = decisions_.size();
    publisher_.publish(estimate);
    waitFor([&] { return decisions_.size() > before; });
    return decisions_.back();
  }

  static void set(const char* service, bool value) {
    std_srvs::SetBool call;
    call.request.data = value;
    ASSERT_TRUE(ros::service::call(service, call));
    EXPECT_TRUE(call.response.success);
    EXPECT_FALSE(call.response.message.empty());
  }

  ros::NodeHandle handle_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  std::vector<Decision> decisions_;
  std::uint64_t estimates_ = 0;
};

TEST_F(InjectorTest, FollowsHoldsResetsAndStops) {
  Decision decision = decide();
  EXPECT_EQ(decision.data_sequence, kPeriod - 1);
  EXPECT_EQ(decision.effective_sequence, 2 * kPeriod);
  for (int i = 0; i < 2; ++i) decision = decide();  // the ramp is not at its end
  EXPECT_EQ(decision.state, Decision::TRACKING);
  EXPECT_GT(decision.gamma1, 0.0);
  EXPECT_EQ(decisions_.size(), 3u);

  set("/compensation_injector/hold", true);
  const Decision held = decide();
  EXPECT_EQ(held.state, Decision::HOLDING);
  EXPECT_EQ(decide().gamma1, held.gamma1);
  set("/compensation_injector/hold", false);
  EXPECT_GT(decide().gamma1, held.gamma1);

  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("/compensation_injector/reset", reset));
  EXPECT_TRUE(reset.response.success);
  EXPECT_LT(decide().gamma1, held.gamma1);

  set("/compensation_injector/enable", false);
  for (int i = 0; i < 20; ++i) decision = decide();
  EXPECT_EQ(decision.state, Decision::DISABLED);
  EXPECT_EQ(decision.gain1, 0.0);
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "injector_test");
  return RUN_ALL_TESTS();
}
