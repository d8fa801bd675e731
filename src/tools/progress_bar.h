#pragma once

#include <chrono>
#include <string>

namespace ring_gyro::tools {

/// How far a run is, on a terminal only; elsewhere it says nothing.
class ProgressBar {
 public:
  /// `total`: simulated time of the run, 0 when there is no end [s].
  explicit ProgressBar(double total);
  /// `total` of something other than simulated time, such as "MB".
  ProgressBar(double total, std::string unit);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Cheap enough to be called for each block.
  void show(double simulated) {
    if (visible_ && ++calls_ % kCallsPerLook == 0) draw(simulated);
  }
  /// For steps that are few and long.
  void showNow(double simulated) {
    if (visible_) draw(simulated);
  }
  /// For a run whose end becomes known by and by.
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
