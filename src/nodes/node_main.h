#pragma once

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <cstdlib>
#include <exception>
#include <sstream>
#include <string>

#include "ring_gyro/nodes/network_thread_spinner.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/ros/node_configuration.h"

namespace ring_gyro {

/// Each line of `text` as a FATAL of its own, so that a log shows every fault with its node.
inline void logFatalLines(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ROS_FATAL_STREAM(line);
}

/// A node as a process of its own: main() of every executable. Returns its exit code.
template <typename Node>
int runNode(int argc, char** argv, const char* name) {
  int exit_code = EXIT_SUCCESS;
  try {
    ros::init(argc, argv, name);
    NetworkThreadSpinner spinner;
    ros::start();  // otherwise the last handle ends ROS, and with it the log, before the catch
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
    Node node(handle, private_handle, readNodeConfiguration(private_handle), host);
    spinner.run();
  } catch (const std::exception& error) {
    logFatalLines(error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();
  return exit_code;
}

}  // namespace ring_gyro
