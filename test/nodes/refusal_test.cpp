// Nodes that cannot do their work say why and end with a code other than zero.

#include <gtest/gtest.h>
#include <nodelet/NodeletLoad.h>
#include <ros/ros.h>
#include <sys/wait.h>

#include <cstdio>
#include <memory>
#include <string>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::test {
namespace {

const char* const kNodes[] = {"plant_simulator",       "control_loops", "ekf_identifier",
                              "compensation_injector", "calibration",   "bag_recorder"};

struct Outcome {
  std::string text;  // of both streams
  int exit_code = -1;
};

Outcome run(const std::string& node, const std::string& name) {
  const std::string command =
      std::string(RING_GYRO_NODE_DIR) + "/" + node + "_node __name:=" + name + " 2>&1";
  Outcome outcome;
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return outcome;
  char buffer[4096];
  while (std::fgets(buffer, sizeof(buffer), pipe) != nullptr) outcome.text += buffer;
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

/// The line of a log that has `part`, empty when there is none.
std::string lineWith(const std::string& text, const std::string& part) {
  const std::size_t found = text.find(part);
  if (found == std::string::npos) return "";
  const std::size_t begin = text.rfind('\n', found) + 1;
  return text.substr(begin, text.find('\n', found) - begin);
}

void setGoodParameters(const std::string& name) {
  for (const char* section : {"device", "resonator"}) {
    const std::string prefix = "/" + name + "/" + section + "/";
    ros::param::set(prefix + "natural_frequency", 14.0e3);
    ros::param::set(prefix + "quality_factor", 22000);
    ros::param::set(prefix + "drive_gain", "1.1e5");  // as rosparam hands it on
  }
}

void setFaultyParameters(const std::string& name) {
  setGoodParameters(name);
  ros::param::del("/" + name + "/device/drive_gain");
  ros::param::set("/" + name + "/control/virtual_rate", "fast");
  ros::param::set("/" + name + "/run/seed", -1);
  ros::param::set("/" + name + "/control/virtul_rate", 0.2);
  ros::param::set("/" + name + "/node/lockstep", 3);
  ros::param::set("/" + name + "/calibration_run/drift_rounds", 0);
}

TEST(Refusal, EveryNodeNamesEveryFaultOnALine) {
  for (const std::string node : kNodes) {
    const std::string name = "faulty_" + node;
    setFaultyParameters(name);
    const Outcome outcome = run(node, name);
    EXPECT_GT(outcome.exit_code, 0) << node << ": " << outcome.text;
    for (const char* fault :
         {"device/drive_gain: missing; it must be given; allowed: > 0 [1/s^2]",
          "control/virtual_rate = fast: not a number; allowed: [-100, 100] [rad/s]",
          "run/seed = -1: out of range; allowed: [0, 2.14748e+09], whole",
          "control/virtul_rate = 0.2: unknown parameter; did you mean control/virtual_rate?",
          "node/lockstep = 3: not true or false",
          "calibration_run/drift_rounds = 0: out of range; allowed: [1, 10], whole"}) {
      const std::string line = lineWith(outcome.text, fault);
      EXPECT_NE(line.find("FATAL"), std::string::npos) << node << ": " << fault << "\n"
                                                       << outcome.text;
    }
  }
}

TEST(Refusal, WhatTheCoreRefusesIsFatalToo) {
  setGoodParameters("held");
  ros::param::set("/held/drive/dac_bits", 16);
  const Outcome outcome = run("plant_simulator", "held");
  EXPECT_GT(outcome.exit_code, 0);
  EXPECT_NE(lineWith(outcome.text, "zero_order_hold").find("FATAL"), std::string::npos)
      << outcome.text;
}

TEST(Refusal, CalibrationNeedsAFileAndNoDurationAndLoopsThatListen) {
  setGoodParameters("careless");
  const Outcome outcome = run("calibration", "careless");
  EXPECT_GT(outcome.exit_code, 0);
  for (const char* fault :
       {"node/calibration_file: missing", "run/duration = 130: a calibration run lasts until it",
        "control/calibration_run = false: the loops would not do what"}) {
    EXPECT_NE(lineWith(outcome.text, fault).find("FATAL"), std::string::npos) << outcome.text;
  }
}

TEST(Refusal, CalibrationIsToldBeforeTheRunThatItsFileCannotBeWritten) {
  setGoodParameters("nowhere");
  ros::param::set("/nowhere/node/calibration_file", "/no/such/folder/calibration.yaml");
  ros::param::set("/nowhere/run/duration", 0.0);
  ros::param::set("/nowhere/control/calibration_run", true);
  const Outcome outcome = run("calibration", "nowhere");
  EXPECT_GT(outcome.exit_code, 0);
  EXPECT_NE(lineWith(outcome.text, "calibration.yaml: cannot be written").find("FATAL"),
            std::string::npos)
      << outcome.text;
}

TEST(Refusal, LoopsTakeTheDampingCompensationFromOneNodeOnly) {
  setGoodParameters("two_masters");
  ros::param::set("/two_masters/control/compensation", true);
  ros::param::set("/two_masters/control/calibration_run", true);
  const Outcome outcome = run("control_loops", "two_masters");
  EXPECT_GT(outcome.exit_code, 0);
  EXPECT_NE(lineWith(outcome.text, "compensation and calibration_run cannot both").find("FATAL"),
            std::string::npos)
      << outcome.text;
}

TEST(Refusal, ManagerDoesNotLoadAFaultyNodelet) {
  ASSERT_TRUE(ros::service::waitForService("/manager/load_nodelet", ros::Duration(30.0)));
  for (const std::string node : {"plant_simulator", "control_loops", "ekf_identifier",
                                 "compensation_injector", "calibration"}) {
    const std::string name = "faulty_nodelet_" + node;
    setFaultyParameters(name);
    nodelet::NodeletLoad load;
    load.request.name = "/" + name;
    load.request.type = "ring_gyro/" + node;
    const bool loaded = ros::service::call("/manager/load_nodelet", load) && load.response.success;
    EXPECT_FALSE(loaded) << node;
  }
}

TEST(Silence, PlantNamesWhoDoesNotAnswer) {
  setGoodParameters("lonely_plant");
  ros::param::set("/lonely_plant/node/lockstep_timeout", 0.5);
  ros::NodeHandle handle;
  // Listens, but never answers.
  const boost::function<void(const ring_gyro::DisplacementBlock::ConstPtr&)> ignore =
      [](const ring_gyro::DisplacementBlock::ConstPtr&) {};
  const ros::Subscriber listener =
      handle.subscribe<ring_gyro::DisplacementBlock>(bridge::topics::kDisplacement, 10, ignore);
  const Outcome outcome = run("plant_simulator", "lonely_plant");
  EXPECT_GT(outcome.exit_code, 0);
  const std::string line = lineWith(outcome.text, "no drive command has answered block 0");
  EXPECT_NE(line.find("FATAL"), std::string::npos) << outcome.text;
  EXPECT_NE(line.find(ros::this_node::getName()), std::string::npos) << outcome.text;
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "refusal_test");
  ros::start();
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
