#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cvg {

/// Sampling period [s] of rows with these times, gaps and rounding of the times aside; a period
/// that is as good as a whole number of microseconds or of rows per second becomes exactly that.
/// Throws std::invalid_argument when no period can be seen.
double samplingPeriod(const std::vector<double>& times);

/// Puts rows onto an even grid: how many periods each row is behind the one before.
class RowClock {
 public:
  explicit RowClock(double period) : period_(period) {}

  double period() const { return period_; }
  /// Whole periods since the row before, at least 1 (0 for the first row). Throws
  /// std::invalid_argument when time does not grow or falls between the grid's points.
  std::int64_t step(double time);

 private:
  double period_;
  bool started_ = false;
  double last_ = 0.0;
  double grid_ = 0.0;  // where the last row should have been
};

}  // namespace cvg
