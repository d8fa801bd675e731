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

/// Ends a node without loss. When the plant has announced the last block and the node has processed
/// it, the node unsubscribes from its inputs, waits until the readers of its outputs have
/// unsubscribed too (so that no message on the way to them is lost), and finishes.
///
/// Only the end of the node's own session counts. A node that has seen no data yet keeps an
/// announcement until its first block shows the session, so that the latched end of an earlier run
/// ends no node. When data of a new session arrive, the end of the previous session is void.
class Departure {
 public:
  /// `leave`: ends the node's subscriptions and completes its work; called once.
  Departure(ros::NodeHandle& handle, const cvg::NodeParameters& parameters, NodeHost host,
            std::vector<Output> outputs, std::function<void()> leave);

  /// The plant has announced the last block of the session that the node is in.
  bool announced() const { return announced_; }

  /// A message of this session has arrived; fast, to be called for each message.
  void inSession(std::uint32_t session) {
    if (!in_session_ || session != session_) enterSession(session);
  }

  /// Number of announced ends of other sessions, which were ignored.
  std::uint64_t foreign() const { return foreign_; }

  /// Leaves now: the node has finished its work before the announced end.
  void leaveNow();

  /// The node has processed this block of its session; fast, to be called for each block.
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
  std::optional<ring_gyro::EndOfRun> early_;  // arrived before any data
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
