#include "ring_gyro/resonator/rotation_profile.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/number_text.h"

namespace cvg {

void RotationParameters::declare(ParameterTable& table) {
  table
      .choice("profile", profile, {"constant", "step", "sine", "file"},
              "rotation rate of the case against time")
      .number("rate", rate, "rad/s", Range::between(-1e3, 1e3),
              "constant: the rate; step: the rate after step_time; sine: its mean")
      .number("step_time", step_time, "s", Range::atLeast(0.0), "when the step happens")
      .number("amplitude", amplitude, "rad/s", Range::between(-1e3, 1e3), "of the sine")
      .number("frequency", frequency, "Hz", Range::between(0.0, 1e4), "of the sine")
      .text("file", file, "two columns: time [s], rate [rad/s]; straight lines between rows");
}

RotationProfile::RotationProfile(const RotationParameters& parameters)
    : parameters_(checked(parameters, "rotation")) {
  if (parameters_.profile != RotationShape::kFile) return;
  std::ifstream in(parameters_.file);
  if (!in) {
    throw std::invalid_argument("rotation: file '" + parameters_.file +
                                "' cannot be opened; name a readable file with two columns");
  }
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream columns(line);
    std::vector<std::string> cells;
    for (std::string cell; columns >> cell;) cells.push_back(cell);
    if (cells.empty() || cells.front().front() == '#') continue;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double time = cells.size() == 2 ? parseNumber(cells[0]).value_or(nan) : nan;
    const double rate = cells.size() == 2 ? parseNumber(cells[1]).value_or(nan) : nan;
    if (!std::isfinite(time) || !std::isfinite(rate) ||
        (!times_.empty() && time <= times_.back())) {
      throw std::invalid_argument("rotation: " + parameters_.file + ":" + std::to_string(number) +
                                  ": '" + line + "' is not a growing time [s] and a rate [rad/s]");
    }
    angles_.push_back(times_.empty()
                          ? 0.0
                          : angles_.back() + 0.5 * (rate + rates_.back()) * (time - times_.back()));
    times_.push_back(time);
    rates_.push_back(rate);
  }
  if (times_.empty()) {
    throw std::invalid_argument("rotation: file '" + parameters_.file +
                                "' has no rows; give a time [s] and a rate [rad/s] a row");
  }
}

double RotationProfile::rate(double time) const {
  const RotationParameters& p = parameters_;
  if (p.profile == RotationShape::kConstant) return p.rate;
  if (p.profile == RotationShape::kStep) return time < p.step_time ? 0.0 : p.rate;
  if (p.profile == RotationShape::kSine) {
    return p.rate + p.amplitude * std::sin(kTwoPi * p.frequency * time);
  }
  if (time <= times_.front()) return rates_.front();
  if (time >= times_.back()) return rates_.back();
  const auto after = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin();
  const double share = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
  return rates_[after - 1] + share * (rates_[after] - rates_[after - 1]);
}

double RotationProfile::angle(double time) const {
  const RotationParameters& p = parameters_;
  if (p.profile == RotationShape::kConstant) return p.rate * time;
  if (p.profile == RotationShape::kStep) return p.rate * std::max(0.0, time - p.step_time);
  if (p.profile == RotationShape::kSine) {
    const double w = kTwoPi * p.frequency;
    const double half = std::sin(0.5 * w * time);
    const double swing = w > 0.0 ? 2.0 * half * half / w : 0.0;
    return p.rate * time + p.amplitude * swing;
  }
  if (time <= times_.front()) return (time - times_.front()) * rates_.front();
  if (time >= times_.back()) return angles_.back() + (time - times_.back()) * rates_.back();
  const auto before = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin() - 1;
  return angles_[before] + 0.5 * (rates_[before] + rate(time)) * (time - times_[before]);
}

double RotationProfile::meanRate(double begin, double end) const {
  if (parameters_.profile == RotationShape::kConstant) return parameters_.rate;
  return (angle(end) - angle(begin)) / (end - begin);
}

bool RotationProfile::isConstant(double begin, double end) const {
  const RotationParameters& p = parameters_;
  if (p.profile == RotationShape::kConstant) return true;
  if (p.profile == RotationShape::kStep) return end <= p.step_time || begin >= p.step_time;
  if (p.profile == RotationShape::kSine) return p.amplitude == 0.0 || p.frequency == 0.0;
  return end <= times_.front() || begin >= times_.back();
}

}  // namespace cvg
