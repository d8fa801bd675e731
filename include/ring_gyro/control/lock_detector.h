#pragma once

#include <cstdint>

namespace cvg {

/// Locked when a condition has been true for a number of blocks without interruption.
class LockDetector {
 public:
  explicit LockDetector(std::int64_t blocks_to_hold) : blocks_to_hold_(blocks_to_hold) {}

  bool update(bool within_bounds) {
    held_ = within_bounds ? (held_ < blocks_to_hold_ ? held_ + 1 : held_) : 0;
    return locked();
  }
  bool locked() const { return held_ >= blocks_to_hold_; }
  void reset() { held_ = 0; }

 private:
  std::int64_t blocks_to_hold_;
  std::int64_t held_ = 0;
};

}  // namespace cvg
