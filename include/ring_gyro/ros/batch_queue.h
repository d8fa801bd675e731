#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

namespace ring_gyro::bridge {

/// Passes items from one thread to another in order, in batches, with a bounded number on the way.
/// Empty batches come back and are filled again, so that in the long run nothing is allocated.
template <typename Item>
class BatchQueue {
 public:
  using Batch = std::vector<Item>;

  /// Writer: exchanges `batch` for an empty one; false when the reader wants no more.
  bool give(Batch& batch) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return full_.size() < kMostWaiting || cancelled_; });
    if (cancelled_) return false;
    full_.push_back(std::move(batch));
    batch = Batch();
    if (!empty_.empty()) {
      batch = std::move(empty_.back());
      empty_.pop_back();
    }
    changed_.notify_all();
    return true;
  }
  /// Writer: this was the last batch.
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  /// Reader: exchanges a batch that has been read for the next one; false at the end.
  bool take(Batch& batch) {
    std::unique_lock<std::mutex> lock(mutex_);
    batch.clear();
    empty_.push_back(std::move(batch));
    changed_.wait(lock, [this] { return !full_.empty() || closed_; });
    if (full_.empty()) return false;
    batch = std::move(full_.front());
    full_.erase(full_.begin());
    changed_.notify_all();
    return true;
  }
  /// Reader: wants no more.
  void cancel() {
    const std::lock_guard<std::mutex> lock(mutex_);
    cancelled_ = true;
    changed_.notify_all();
  }

 private:
  static constexpr std::size_t kMostWaiting = 8;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Batch> full_;
  std::vector<Batch> empty_;
  bool closed_ = false;
  bool cancelled_ = false;
};

}  // namespace ring_gyro::bridge
