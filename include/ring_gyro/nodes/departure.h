#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "ring_gyro/configuration/node_parameters.h"
#include "ring_gyro/nodes/node_host.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro::nodes {

/// Ends a node in order: when the plant has announced the last block and the node has dealt with
/// it, the node takes its leave of its inputs, waits until those who read its outputs have done so
/// too (nothing on the way to them is lost), and finishes.
///
/// Only the end of the session that the node is in counts. A node that has seen no data yet keeps
/// what was announced until its first block tells of which session it is: the latched end of an
/// earlier run ends nobody. When data of a new session come, the end of the one before is void.
class Departure {
 public:
  /// `leave`: ends the node's subscriptions and whatever it has to conclude; called once.
  Departure(ros::NodeHandle& handle, const cvg::NodeParameters& parameters, NodeHost host,
            std::vector<Output> outputs, std::function<void()> leave);

  /// The plant has announced the last block of the session that the node is in.
  bool announced() const { return announced_; }

  /// A message of this session has come; cheap, to be called for each.
  void inSession(std::uint32_t session) {
    if (!in_session_ || session != session_) enterSession(session);
  }

  /// Ends of other sessions that were announced and left out.
  std::uint64_t foreign() const { return foreign_; }

  /// The node has nothing more to do, whatever the plant may announce.
  void leaveNow();

  /// The node has dealt with this block of its session; cheap, to be called for each.
  void processed(std::uint64_t sequence) {
    last_processed_ = sequence;
    any_processed_ = true;
    if (announced_ && !leaving_) leaveIfDone();
  }

 private:
  void onEndOfRun(const ring_gyro::EndOfRun& message);
  void enterSession(std::uint32_t session);
  void announce(const ring_gyro::EndOfRun& message);
  void leaveOut(const ring_gyro::EndOfRun& message);
  void leaveIfDone();
  void leave();
  void tick();

  std::size_t allowed_subscribers_;
  int ticks_allowed_;
  NodeHost host_;
  std::vector<Output> outputs_;
  std::function<void()> leave_;
  bool in_session_ = false;
  std::uint32_t session_ = 0;
  std::optional<ring_gyro::EndOfRun> early_;  // came before any data
  std::uint64_t foreign_ = 0;
  bool announced_ = false;
  bool leaving_ = false;
  bool any_processed_ = false;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t last_processed_ = 0;
  std::uint64_t processed_at_tick_ = 0;
  int idle_ticks_ = 0;
  int leaving_ticks_ = 0;
  ros::Subscriber subscriber_;
  ros::WallTimer timer_;
};

}  // namespace ring_gyro::nodes
