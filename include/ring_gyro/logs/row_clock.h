#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cvg {

/// Sampling period [s] of rows with these times; ignores gaps and the rounding of the times. A
/// period very near to a whole number of microseconds, or of rows per second, becomes exactly this
/// number. Throws std::invalid_argument when no period can be found.
double samplingPeriod(const std::vector<double>& times);

/// Assigns rows to an even grid: gives the number of periods from each row to the next.
class RowClock {
 public:
  explicit RowClock(double period) : period_(period) {}

  double period() const { return period_; }
  /// Whole periods since the previous row, at least 1 (0 for the first row). Throws
  /// std::invalid_argument when time does not grow or is between the points of the grid.
  std::int64_t step(double time);

 private:
  double period_;
  bool started_ = false;
  double last_ = 0.0;
  double grid_ = 0.0;  // grid time of the last row
};

}  // namespace cvg
