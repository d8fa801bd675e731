#include "ring_gyro/nodes/refusals.h"

#include <ros/console.h>

namespace ring_gyro::nodes {
namespace {

constexpr std::chrono::seconds kQuiet(10);  // between two lines about the same reason

}  // namespace

void Refusals::add(const std::string& topic, std::uint64_t block,
                   const bridge::MessageFault& fault) {
  add(topic, std::string(fault.field) + " " + fault.reason,
      "block " + std::to_string(block) + ": " + fault.text);
}

void Refusals::add(const std::string& topic, const std::string& reason, const std::string& text) {
  ++total_;
  Kind& kind = kinds_["refused " + topic + ": " + reason];
  ++kind.count;
  const WallClock::time_point now = WallClock::now();
  if (kind.count > 1 && now < kind.said_at + kQuiet) return;
  kind.said_at = now;
  ROS_WARN("refused %s, %s (%lu of this kind)", topic.c_str(), text.c_str(),
           static_cast<unsigned long>(kind.count));
}

void Refusals::addTo(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  status.add("refused messages", total_);
  for (const auto& [reason, kind] : kinds_) status.add(reason, kind.count);
}

}  // namespace ring_gyro::nodes
