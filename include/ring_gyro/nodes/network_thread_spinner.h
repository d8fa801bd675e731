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
/// A block that goes round the loop between processes then wakes one thread in each of them. With
/// ros::spin() it is three (socket, callback, socket), and waking threads is where the time of a
/// run goes. Callbacks are still one at a time and never within roscpp's own locks on a topic.
class NetworkThreadSpinner {
 public:
  /// To be made before ros::start(): what a callback publishes then goes out in the same turn.
  NetworkThreadSpinner();
  ~NetworkThreadSpinner();
  NetworkThreadSpinner(const NetworkThreadSpinner&) = delete;
  NetworkThreadSpinner& operator=(const NetworkThreadSpinner&) = delete;

  /// The queue for the node's handles; it must outlive all that they made.
  ros::CallbackQueueInterface* queue() { return &queue_; }

  /// Runs callbacks until stop() or the end of ROS; none runs any more when it returns.
  /// What a callback throws ends it and is thrown from here.
  void run();

  /// From any thread, callbacks included.
  void stop();

 private:
  /// Wakes up the network thread for callbacks that come from other threads, as those of timers do.
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
