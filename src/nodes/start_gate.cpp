#include "ring_gyro/nodes/start_gate.h"

#include <ros/console.h>

#include <algorithm>
#include <string>
#include <utility>

namespace ring_gyro::nodes {
namespace {

constexpr double kCheckPeriod = 0.02;  // wall time [s]
constexpr int kChecksPerMessage = 250;
constexpr int kChecksForAnswers = 100;

}  // namespace

StartGate::StartGate(ros::NodeHandle& handle, std::vector<Requirement> requirements,
                     std::function<void()> start, std::vector<ros::Subscriber> answers)
    : requirements_(std::move(requirements)),
      answers_(std::move(answers)),
      start_(std::move(start)) {
  timer_ = handle.createWallTimer(ros::WallDuration(kCheckPeriod),
                                  [this](const ros::WallTimerEvent&) { check(); });
}

void StartGate::check() {
  std::string missing;
  for (const Requirement& requirement : requirements_) {
    const std::size_t subscribers = requirement.output.subscribers();
    if (subscribers >= requirement.subscribers) continue;
    missing += " " + requirement.output.topic() + " has " + std::to_string(subscribers) + " of " +
               std::to_string(requirement.subscribers);
  }
  const bool answered =
      std::all_of(answers_.begin(), answers_.end(),
                  [](const ros::Subscriber& answer) { return answer.getNumPublishers() > 0; });
  if (missing.empty() && (answered || ++checks_for_answers_ > kChecksForAnswers)) {
    timer_.stop();
    start_();
  } else if (++checks_ % kChecksPerMessage == 0) {
    ROS_INFO("waiting for subscribers:%s", missing.c_str());
  }
}

}  // namespace ring_gyro::nodes
