#include "ring_gyro/nodes/use_watch.h"

#include "ring_gyro/ros/identification_report.h"

namespace ring_gyro::nodes {

std::string UseWatch::noneSinceLast(const cvg::BlockUseCounts& uses) {
  const cvg::BlockUseCounts recent = uses - last_;
  last_ = uses;
  if (recent.usable() > 0 || recent.unusable() == 0) return "";
  return "none of the last " + std::to_string(recent.unusable()) +
         " blocks can be used: " + bridge::mainReasonOf(recent);
}

void UseWatch::addTo(diagnostic_updater::DiagnosticStatusWrapper& status,
                     const cvg::BlockUseCounts& uses) {
  status.add("usable blocks", uses.usable());
  status.add("unusable blocks", uses.unusable());
  for (const bridge::UnusableReason& reason : bridge::reasonsOf(uses)) {
    status.add(std::string("blocks ") + reason.text, reason.blocks);
  }
}

}  // namespace ring_gyro::nodes
