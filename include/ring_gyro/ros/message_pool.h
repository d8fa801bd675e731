#pragma once

#include <atomic>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <vector>

namespace ring_gyro::bridge {

/// Messages to publish by pointer. A message is reused when no reader holds it any more, so the
/// loop allocates nothing per block. For one publishing thread; readers may be in other threads.
template <typename Message>
class MessagePool {
 public:
  /// A message that nobody else holds; it still has the contents of an earlier use.
  boost::shared_ptr<Message> take() {
    for (std::size_t tried = 0; tried < messages_.size(); ++tried) {
      next_ = next_ + 1 < messages_.size() ? next_ + 1 : 0;
      if (messages_[next_].use_count() == 1) {
        std::atomic_thread_fence(std::memory_order_acquire);
        return messages_[next_];
      }
    }
    if (messages_.size() == kMostKept) return boost::make_shared<Message>();
    messages_.push_back(boost::make_shared<Message>());
    return messages_.back();
  }

 private:
  static constexpr std::size_t kMostKept = 64;

  std::vector<boost::shared_ptr<Message>> messages_;
  std::size_t next_ = 0;
};

}  // namespace ring_gyro::bridge
