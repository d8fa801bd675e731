#include "ring_gyro/nodes/bag_recorder_node.h"

#include <ros/console.h>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/signals/calibration_command.h"

namespace ring_gyro::nodes {
namespace {

constexpr std::uint32_t kUnlimited = 0;
// Limit of messages that wait for those of other topics. A graph of nodelets sends faster than
// sockets are read, and a socket is read until it is empty before the next one is read. So topics
// arrive in bursts, as long as the queues that the plant and the loops allow (ReaderWait).
constexpr std::size_t kMostWaiting = 256u << 20;
constexpr std::int64_t kLongestWait = 1'000'000'000;  // in real time, where queues stay short [ns]

bridge::StampMerge::Limits limits(const cvg::NodeParameters& parameters) {
  bridge::StampMerge::Limits result;
  result.bytes = kMostWaiting;
  if (!parameters.lockstep) result.span_ns = kLongestWait;
  return result;
}

const std::string& fileName(const cvg::NodeParameters& parameters) {
  if (parameters.bag.empty()) {
    throw cvg::ConfigurationError(
        {"node/bag: missing; the recorder must be told which file to write"});
  }
  return parameters.bag;
}

}  // namespace

BagRecorderNode::BagRecorderNode(const ros::NodeHandle& handle,
                                 const ros::NodeHandle& /*private_handle*/,
                                 const bridge::NodeConfiguration& configuration, NodeHost host)
    : handle_(handle),
      host_(std::move(host)),
      period_blocks_(configuration.loop.periodBlocks()),
      period_ns_(static_cast<std::int64_t>(period_blocks_ - 1) *
                 configuration.loop.converter.blockDurationNanoseconds()),
      writer_(fileName(configuration.node)),
      order_(limits(configuration.node)),
      departure_(handle_, configuration.node, host_, {}, [this] { finish(); }) {
  const auto sequence = [](const auto& message) { return message.sequence; };
  // No estimate, decision or command of a calibration covers the blocks after the last whole
  // period.
  const auto after = [this](std::uint64_t block) { return block + period_blocks_ - 1; };
  record<ring_gyro::OrbitalElements>(bridge::topics::kOrbitalElements, sequence);
  record<ring_gyro::ControlGains>(bridge::topics::kControlGains, sequence);
  record<ring_gyro::ParameterEstimate>(
      bridge::topics::kParameterEstimate,
      [after](const auto& message) { return after(message.last_sequence); }, Sent::kEachPeriod);
  record<ring_gyro::CompensationGains>(
      bridge::topics::kCompensationGains,
      [after](const auto& message) { return after(message.data_sequence); }, Sent::kEachPeriod);
  record<ring_gyro::CalibrationCommand>(
      bridge::topics::kCalibrationCommand,
      [after](const auto& message) { return after(message.data_sequence); }, Sent::kEachPeriod);
  if (configuration.node.record_raw) {
    record<ring_gyro::DisplacementBlock>(bridge::topics::kDisplacement, sequence);
    record<ring_gyro::DriveCommand>(bridge::topics::kDriveCommand,
                                    [](const auto& message) { return message.answers_sequence; });
  }
  record<ring_gyro::EndOfRun>(
      bridge::topics::kEndOfRun, [](const auto& message) { return message.last_sequence; },
      Sent::kOnce);
  // The truth is last: the plant waits for its subscriber, and then all other topics have one too.
  record<ring_gyro::PlantTruth>(bridge::topics::kPlantTruth, sequence);
}

BagRecorderNode::~BagRecorderNode() {
  // Stopped before the end of the run: the bag is still complete up to here.
  if (!finished_) ROS_WARN("%s: the run was cut: stopped before its end", writer_.path().c_str());
  try {
    finish();
  } catch (const std::exception& error) {
    ROS_ERROR("%s", error.what());
  }
}

template <typename Message, typename BlockOf>
void BagRecorderNode::record(const char* name, BlockOf blockOf, Sent sent) {
  topics_.emplace_back();
  Topic& topic = topics_.back();
  topic.name = name;
  const std::size_t number =
      order_.addTopic({sent != Sent::kOnce, sent == Sent::kEachPeriod ? period_ns_ : 0,
                       [&topic] { return topic.subscriber.getNumPublishers() > 0; }});
  topic.subscriber = handle_.subscribe<Message>(
      name, kUnlimited,
      [this, &topic, number, blockOf](const boost::shared_ptr<const Message>& message) {
        if (finished_) return;
        try {
          order_.add(number, message->session,
                     static_cast<std::int64_t>(message->header.stamp.toNSec()),
                     ros::serialization::serializationLength(*message),
                     [this, &topic, message] { writer_.write(topic.name, *message); });
        } catch (const std::exception& error) {
          finished_ = true;
          host_.fail(error.what());
          return;
        }
        // The end of a run counts only if it is of the recorded run.
        if constexpr (std::is_same_v<Message, ring_gyro::OrbitalElements> ||
                      std::is_same_v<Message, ring_gyro::PlantTruth>) {
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
    // Do not wait for a topic without a publisher.
    if (!topic.any && topic.subscriber.getNumPublishers() == 0) continue;
    complete = std::min(complete, topic.any ? topic.complete_up_to : 0);
  }
  departure_.processed(complete);
}

void BagRecorderNode::finish() {
  if (finished_) return;
  finished_ = true;
  for (Topic& topic : topics_) topic.subscriber.shutdown();
  order_.flush();
  writer_.finish();
  ROS_INFO("%lu messages in %s", static_cast<unsigned long>(writer_.messages()),
           writer_.path().c_str());
  if (order_.late() > 0) {
    ROS_WARN(
        "%lu of them are out of order: their topics came too late to be waited for; rosbag play "
        "will be slow with them, the tools of this package will not",
        static_cast<unsigned long>(order_.late()));
  }
}

}  // namespace ring_gyro::nodes
