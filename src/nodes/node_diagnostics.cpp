#include "ring_gyro/nodes/node_diagnostics.h"

#include <utility>

namespace ring_gyro::nodes {

NodeDiagnostics::NodeDiagnostics(const ros::NodeHandle& handle,
                                 const ros::NodeHandle& private_handle, const std::string& node,
                                 Report report)
    : updater_(handle, private_handle, node) {
  updater_.setHardwareID("ring_gyro");
  updater_.add("state", std::move(report));
  timer_ = handle.createWallTimer(ros::WallDuration(1.0),
                                  [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

}  // namespace ring_gyro::nodes
