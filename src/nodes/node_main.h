#pragma once

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/topic_manager.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <sstream>
#include <string>
#include <thread>

#include "ring_gyro/nodes/network_thread_spinner.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/ros/node_configuration.h"

namespace ring_gyro::nodes {

/// Logs each line of `text` as a separate FATAL, so that a log shows every fault with its node.
inline void logFatalLines(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ROS_FATAL_STREAM(line);
}

/// Waits until the plant, the only publisher of /clock, has exited, for at most `timeout` seconds
/// of wall time: a launch file may treat any node that exits before the plant as one that died.
inline void outlastPlant(double timeout) {
  constexpr std::chrono::milliseconds kLook(20);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
  while (ros::ok() && ros::TopicManager::instance()->getNumPublishers("/clock") > 0 &&
         std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kLook);
  }
}

/// Runs a node as a separate process: main() of every executable. `ends_last`: true for the plant,
/// for which the others wait when they have finished. Returns the exit code.
template <typename Node>
int runNode(int argc, char** argv, const char* name, bool ends_last = false) {
  int exit_code = EXIT_SUCCESS;
  try {
    ros::init(argc, argv, name);
    NetworkThreadSpinner spinner;
    ros::start();  // otherwise the last handle would shut down ROS and its log before the catch
    ros::NodeHandle handle;
    ros::NodeHandle private_handle("~");
    handle.setCallbackQueue(spinner.queue());
    private_handle.setCallbackQueue(spinner.queue());
    NodeHost host;
    host.finish = [&spinner] { spinner.stop(); };
    host.fail = [&spinner, &exit_code](const std::string& why) {
      logFatalLines(why);
      exit_code = EXIT_FAILURE;
      spinner.stop();
    };
    const bridge::NodeConfiguration configuration = bridge::readNodeConfiguration(private_handle);
    Node node(handle, private_handle, configuration, host);
    spinner.run();
    // A player also publishes /clock, but it waits for the node.
    const bool live = configuration.node.replay.empty();
    if (live && !ends_last && exit_code == EXIT_SUCCESS) {
      outlastPlant(configuration.node.exit_timeout);
    }
  } catch (const std::exception& error) {
    logFatalLines(error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();
  return exit_code;
}

}  // namespace ring_gyro::nodes
