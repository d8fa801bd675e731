#include "ring_gyro/nodes/network_thread_spinner.h"

#include <ros/init.h>
#include <ros/poll_manager.h>

#include <chrono>

namespace ring_gyro::nodes {
namespace {

constexpr std::chrono::milliseconds kLookForShutdown(50);

}  // namespace

void NetworkThreadSpinner::Queue::addCallback(const ros::CallbackInterfacePtr& callback,
                                              std::uint64_t id) {
  ros::CallbackQueue::addCallback(callback, id);
  if (std::this_thread::get_id() != network_thread_.load(std::memory_order_relaxed)) {
    ros::PollManager::instance()->getPollSet().signal();
  }
}

NetworkThreadSpinner::NetworkThreadSpinner()
    : connection_(
          ros::PollManager::instance()->addPollThreadListener([this] { callAvailable(); })) {}

NetworkThreadSpinner::~NetworkThreadSpinner() {
  // This call waits for a running callback.
  ros::PollManager::instance()->removePollThreadListener(connection_);
}

void NetworkThreadSpinner::callAvailable() {
  queue_.setNetworkThread(std::this_thread::get_id());
  try {
    while (running_ && !queue_.isEmpty()) queue_.callAvailable(ros::WallDuration(0.0));
  } catch (...) {
    thrown_ = std::current_exception();
    stop();
  }
}

void NetworkThreadSpinner::run() {
  running_ = true;
  ros::PollManager::instance()->getPollSet().signal();
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stopped_ && ros::ok()) stopped_changed_.wait_for(lock, kLookForShutdown);
  }
  running_ = false;
  ros::PollManager::instance()->removePollThreadListener(connection_);
  if (thrown_) std::rethrow_exception(thrown_);
}

void NetworkThreadSpinner::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  running_ = false;
  stopped_ = true;
  stopped_changed_.notify_all();
}

}  // namespace ring_gyro::nodes
