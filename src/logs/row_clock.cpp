#include "ring_gyro/logs/row_clock.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/number_text.h"

namespace cvg {
namespace {

constexpr double kFollow = 0.02;  // share of a deviation that the grid follows, for drifting clocks

std::string text(double value) {
  std::string result;
  appendNumber(result, value);
  return result;
}

}  // namespace

double samplingPeriod(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) steps.push_back(times[k] - times[k - 1]);
  }
  if (steps.empty()) throw std::invalid_argument("time does not grow over the first rows");
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  double period = steps[steps.size() / 2];
  // Times may be rounded coarsely, so count whole periods over all rows, with a better period in
  // each pass.
  for (int pass = 0; pass < 3; ++pass) {
    double elapsed = 0.0;
    double periods = 0.0;
    for (std::size_t k = 1; k < times.size(); ++k) {
      const double step = times[k] - times[k - 1];
      if (!(step > 0.0) || step > 1.9 * period) continue;  // a gap, or the clock was set back
      elapsed += step;
      periods += 1.0;
    }
    if (periods > 0.0) period = elapsed / periods;
  }
  // Uncertainty of the period: the scatter of all times about an even grid.
  double position = 0.0;
  double lowest = 0.0;
  double highest = 0.0;
  for (std::size_t k = 1; k < times.size(); ++k) {
    const double step = times[k] - times[k - 1];
    if (!(step > 0.0) || step > 1.9 * period) continue;
    position += step - period;
    lowest = std::min(lowest, position);
    highest = std::max(highest, position);
  }
  const double tolerance =
      std::max(1e-9, 2.0 * (highest - lowest) / (period * static_cast<double>(times.size())));
  const double microseconds = std::round(1e6 * period);
  if (microseconds >= 1.0 && std::abs(1e6 * period / microseconds - 1.0) < tolerance) {
    return 1e-6 * microseconds;
  }
  const double rate = std::round(1.0 / period);
  if (rate >= 1.0 && std::abs(rate * period - 1.0) < tolerance) return 1.0 / rate;
  return period;
}

std::int64_t RowClock::step(double time) {
  if (!started_) {
    started_ = true;
    last_ = grid_ = time;
    return 0;
  }
  if (!(time > last_)) {
    throw std::invalid_argument("time " + text(time) + " s does not grow, the row before has " +
                                text(last_) + " s");
  }
  const double periods = (time - grid_) / period_;
  const double whole = std::round(periods);
  if (whole < 1.0) {
    throw std::invalid_argument("time " + text(time) + " s is less than half a period of " +
                                text(period_) + " s behind the row before");
  }
  last_ = time;
  grid_ += whole * period_;
  grid_ += kFollow * (time - grid_);
  return static_cast<std::int64_t>(whole);
}

}  // namespace cvg
