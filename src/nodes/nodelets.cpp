#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>

#include <cstdlib>
#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "node_main.h"
#include "ring_gyro/nodes/calibration_node.h"
#include "ring_gyro/nodes/compensation_injector_node.h"
#include "ring_gyro/nodes/control_loops_node.h"
#include "ring_gyro/nodes/ekf_identifier_node.h"
#include "ring_gyro/nodes/plant_simulator_node.h"

namespace ring_gyro::nodes {

/// A node as a nodelet. If its parameters are wrong, the manager refuses to load it and prints the
/// same lines as the process.
template <typename Node>
class NodeletOf : public nodelet::Nodelet {
 public:
  /// `ends_manager`: the manager exits when this nodelet has finished.
  explicit NodeletOf(bool ends_manager) : ends_manager_(ends_manager) {}

 private:
  void onInit() override {
    try {
      NodeHost host;
      host.finish = [this] {
        if (ends_manager_) ros::shutdown();
      };
      host.fail = [](const std::string& why) {
        logFatalLines(why);
        ros::shutdown();
        // The manager's main() always returns zero.
        std::quick_exit(EXIT_FAILURE);
      };
      node_ = std::make_unique<Node>(inMainThread(getNodeHandle()),
                                     inMainThread(getPrivateNodeHandle()),
                                     bridge::readNodeConfiguration(getPrivateNodeHandle()), host);
    } catch (const std::exception& error) {
      logFatalLines(error.what());
      throw;
    }
  }

  /// Callbacks of all nodelets of the loop run from the manager's own queue, in its main thread. So
  /// a block goes through the loop without changes of thread, which would take most of the time.
  static ros::NodeHandle inMainThread(const ros::NodeHandle& handle) {
    ros::NodeHandle result(handle);
    result.setCallbackQueue(ros::getGlobalCallbackQueue());
    return result;
  }

  bool ends_manager_;
  std::unique_ptr<Node> node_;
};

/// The plant stays until it has no more subscribers, so it finishes last.
class PlantSimulatorNodelet : public NodeletOf<PlantSimulatorNode> {
 public:
  PlantSimulatorNodelet() : NodeletOf(true) {}
};

class ControlLoopsNodelet : public NodeletOf<ControlLoopsNode> {
 public:
  ControlLoopsNodelet() : NodeletOf(false) {}
};

class EkfIdentifierNodelet : public NodeletOf<EkfIdentifierNode> {
 public:
  EkfIdentifierNodelet() : NodeletOf(false) {}
};

class CompensationInjectorNodelet : public NodeletOf<CompensationInjectorNode> {
 public:
  CompensationInjectorNodelet() : NodeletOf(false) {}
};

class CalibrationNodelet : public NodeletOf<CalibrationNode> {
 public:
  CalibrationNodelet() : NodeletOf(false) {}
};

}  // namespace ring_gyro::nodes

PLUGINLIB_EXPORT_CLASS(ring_gyro::nodes::PlantSimulatorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ring_gyro::nodes::ControlLoopsNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ring_gyro::nodes::EkfIdentifierNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ring_gyro::nodes::CompensationInjectorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ring_gyro::nodes::CalibrationNodelet, nodelet::Nodelet)
