#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

namespace ring_gyro::tools {
namespace {

constexpr double kDrawPeriod = 0.1;  // wall time [s]
constexpr int kWidth = 40;           // characters

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

ProgressBar::ProgressBar(double total) : ProgressBar(total, "") {}

ProgressBar::ProgressBar(double total, std::string unit)
    : total_(total), unit_(std::move(unit)), visible_(isatty(STDERR_FILENO) == 1) {}

void ProgressBar::draw(double simulated) {
  const WallClock::time_point now = WallClock::now();
  if (seconds(now - drawn_at_) < kDrawPeriod) return;
  drawn_at_ = now;
  const double speed = simulated / seconds(now - started_at_);
  if (total_ <= 0.0) {
    std::fprintf(stderr, "\r\033[K%.1f s, %.1f times real time", simulated, speed);
    return;
  }
  const double share = std::min(1.0, simulated / total_);
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  if (!unit_.empty()) {
    std::fprintf(stderr, "\r\033[K[%s] %.1f of %.1f %s", bar.c_str(), simulated, total_,
                 unit_.c_str());
    return;
  }
  std::fprintf(stderr, "\r\033[K[%s] %.1f of %.1f s, %.1f times real time", bar.c_str(), simulated,
               total_, speed);
}

void ProgressBar::clear() {
  if (visible_) std::fputs("\r\033[K", stderr);
  visible_ = false;
}

}  // namespace ring_gyro::tools
