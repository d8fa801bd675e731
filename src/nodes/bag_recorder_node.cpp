#include "ring_gyro/nodes/bag_recorder_node.h"

#include <ros/console.h>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro {
namespace {

constexpr std::uint32_t kUnlimited = 0;

const std::string& fileName(const NodeParameters& parameters) {
  if (parameters.bag.empty()) {
    throw ConfigurationError({"node/bag: missing; the recorder must be told which file to write"});
  }
  return parameters.bag;
}

}  // namespace

BagRecorderNode::BagRecorderNode(ros::NodeHandle handle, ros::NodeHandle /*private_handle*/,
                                 const NodeConfiguration& configuration, NodeHost host)
    : handle_(std::move(handle)),
      host_(std::move(host)),
      period_blocks_(configuration.loop.periodBlocks()),
      writer_(fileName(configuration.node)),
      departure_(handle_, configuration.node, host_, {}, [this] { finish(); }) {
  const auto sequence = [](const auto& message) { return message.sequence; };
  // No estimate, decision or command of a calibration covers the blocks after the last whole
  // period.
  const auto after = [this](std::uint64_t block) { return block + period_blocks_ - 1; };
  record<ring_gyro_msgs::OrbitalElements>(topics::kOrbitalElements, sequence);
  record<ring_gyro_msgs::ControlGains>(topics::kControlGains, sequence);
  record<ring_gyro_msgs::ParameterEstimate>(
      topics::kParameterEstimate,
      [after](const auto& message) { return after(message.last_sequence); });
  record<ring_gyro_msgs::CompensationGains>(
      topics::kCompensationGains,
      [after](const auto& message) { return after(message.data_sequence); });
  record<ring_gyro_msgs::CalibrationCommand>(
      topics::kCalibrationCommand,
      [after](const auto& message) { return after(message.data_sequence); });
  if (configuration.node.record_raw) {
    record<ring_gyro_msgs::DisplacementBlock>(topics::kDisplacement, sequence);
    record<ring_gyro_msgs::DriveCommand>(
        topics::kDriveCommand, [](const auto& message) { return message.answers_sequence; });
  }
  record<ring_gyro_msgs::EndOfRun>(topics::kEndOfRun,
                                   [](const auto& message) { return message.last_sequence; });
  // Last: the plant waits for a listener to the truth, and by then there is one to all the rest.
  record<ring_gyro_msgs::PlantTruth>(topics::kPlantTruth, sequence);
}

BagRecorderNode::~BagRecorderNode() {
  // Stopped before the end of the run: what has come so far is a whole bag too.
  if (!finished_) ROS_WARN("%s: the run was cut: stopped before its end", writer_.path().c_str());
  try {
    finish();
  } catch (const std::exception& error) {
    ROS_ERROR("%s", error.what());
  }
}

template <typename Message, typename BlockOf>
void BagRecorderNode::record(const char* name, BlockOf blockOf) {
  topics_.emplace_back();
  Topic& topic = topics_.back();
  const std::string written_name = name;
  topic.subscriber = handle_.subscribe<Message>(
      name, kUnlimited,
      [this, &topic, written_name, blockOf](const boost::shared_ptr<const Message>& message) {
        if (finished_) return;
        try {
          writer_.write(written_name, *message);
        } catch (const std::exception& error) {
          finished_ = true;
          host_.fail(error.what());
          return;
        }
        // The end of a run counts when it is of the run that is being recorded.
        if constexpr (std::is_same_v<Message, ring_gyro_msgs::OrbitalElements> ||
                      std::is_same_v<Message, ring_gyro_msgs::PlantTruth>) {
          departure_.inSession(message->session);
        }
        topic.complete_up_to = blockOf(*message);
        topic.any = true;
        reportProcessed();
      },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

void BagRecorderNode::reportProcessed() {
  if (!departure_.announced()) return;
  std::uint64_t complete = std::numeric_limits<std::uint64_t>::max();
  for (const Topic& topic : topics_) {
    // A topic that nobody publishes is not waited for.
    if (!topic.any && topic.subscriber.getNumPublishers() == 0) continue;
    complete = std::min(complete, topic.any ? topic.complete_up_to : 0);
  }
  departure_.processed(complete);
}

void BagRecorderNode::finish() {
  if (finished_) return;
  finished_ = true;
  for (Topic& topic : topics_) topic.subscriber.shutdown();
  writer_.finish();
  ROS_INFO("%lu messages in %s", static_cast<unsigned long>(writer_.messages()),
           writer_.path().c_str());
}

}  // namespace ring_gyro
