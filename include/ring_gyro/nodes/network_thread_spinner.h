#pragma once

#include <ros/callback_queue.h>

#include <atomic>
#include <boost/signals2/connection.hpp>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>

namespace ring_gyro::nodes {

/// Runs the callbacks of a node in the thread in which roscpp reads and writes its sockets.
///
/// A block on its way through the loop then wakes one thread in each process. With ros::spin() it
/// wakes three (socket, callback, socket), and waking threads takes most of the time of a run.
/// Callbacks still run one at a time and never while roscpp holds its locks on a topic.
class NetworkThreadSpinner {
 public:
  /// Construct it before ros::start(): then a message published by a callback is sent in the same
  /// cycle of the thread.
  NetworkThreadSpinner();
  ~NetworkThreadSpinner();
  NetworkThreadSpinner(const NetworkThreadSpinner&) = delete;
  NetworkThreadSpinner& operator=(const NetworkThreadSpinner&) = delete;

  /// The queue for the node's handles. It must outlive everything that they create.
  ros::CallbackQueueInterface* queue() { return &queue_; }

  /// Runs callbacks until stop() or the shutdown of ROS; when it returns, no callback is running.
  /// An exception of a callback ends it and is rethrown.
  void run();

  /// May be called from any thread, also from callbacks.
  void stop();

 private:
  /// Wakes up the network thread for callbacks from other threads, for example of timers.
  class Queue : public ros::CallbackQueue {
   public:
    void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) override;
    void setNetworkThread(std::thread::id thread) { network_thread_ = thread; }

   private:
    std::atomic<std::thread::id> network_thread_{};
  };

  void callAvailable();

  Queue queue_;
  std::atomic<bool> running_{false};
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable stopped_changed_;
  std::exception_ptr thrown_;
  boost::signals2::connection connection_;  // to roscpp's loop over the sockets
};

}  // namespace ring_gyro::nodes
