#pragma once

#include <chrono>
#include <string>

namespace ring_gyro::tools {

/// Progress of a run, shown on a terminal only.
class ProgressBar {
 public:
  /// `total`: simulated time of the run [s]; 0: no end.
  explicit ProgressBar(double total);
  /// `total` in another unit than simulated time, for example "MB".
  ProgressBar(double total, std::string unit);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Fast enough to be called for each block.
  void show(double simulated) {
    if (visible_ && ++calls_ % kCallsPerLook == 0) draw(simulated);
  }
  /// For a few long steps.
  void showNow(double simulated) {
    if (visible_) draw(simulated);
  }
  /// For a run whose total becomes known later.
  void setTotal(double total) { total_ = total; }
  void clear();

 private:
  using WallClock = std::chrono::steady_clock;
  static constexpr int kCallsPerLook = 256;

  void draw(double simulated);

  double total_;
  std::string unit_;  // empty: simulated time
  bool visible_;
  int calls_ = 0;
  WallClock::time_point started_at_ = WallClock::now();
  WallClock::time_point drawn_at_ = started_at_;
};

}  // namespace ring_gyro::tools
