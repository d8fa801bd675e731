#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <functional>
#include <string>

namespace ring_gyro::nodes {

/// Publishes the state of a node on /diagnostics (REP 107) each second of wall time, even if
/// simulated time differs.
class NodeDiagnostics {
 public:
  using Report = std::function<void(diagnostic_updater::DiagnosticStatusWrapper&)>;

  /// `node`: full name of the node; `report` fills in level, message and values.
  NodeDiagnostics(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                  const std::string& node, Report report);

 private:
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace ring_gyro::nodes
