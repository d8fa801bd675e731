#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Rotation rate of the case against time.
enum class RotationShape : std::uint8_t { kConstant, kStep, kSine, kFile };

struct RotationParameters {
  RotationShape profile = RotationShape::kConstant;
  double rate = 0.0;       ///< constant; step: after step_time; sine: mean [rad/s]
  double step_time = 0.0;  ///< [s]
  double amplitude = 0.0;  ///< sine [rad/s]
  double frequency = 0.0;  ///< sine [Hz]
  std::string file;        ///< two columns: time [s], rate [rad/s]; straight lines between rows

  void declare(ParameterTable& table);
};

/// Rotation rate of the case about its axis against time since the start.
class RotationProfile {
 public:
  /// Throws std::invalid_argument (with file, line and remedy) when the file cannot be used.
  explicit RotationProfile(const RotationParameters& parameters);

  double rate(double time) const;  ///< [rad/s]
  /// Mean of the rate over [begin, end], exact [rad/s].
  double meanRate(double begin, double end) const;
  /// Whether the rate is constant over [begin, end].
  bool isConstant(double begin, double end) const;

 private:
  double angle(double time) const;  // integral of the rate from 0

  RotationParameters parameters_;
  std::vector<double> times_;
  std::vector<double> rates_;
  std::vector<double> angles_;
};

}  // namespace cvg
