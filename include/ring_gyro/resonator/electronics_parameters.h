#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Errors that both the sensing and the driving side have: a gain matrix and a phase delay per
/// axis.
struct AxisErrors {
  double gain_x = 1.0;
  double gain_y = 1.0;
  double misalignment = 0.0;      ///< electrode y turned towards x [rad]
  double phase_delay = 0.0;       ///< of both axes, at the resonance [rad]
  double phase_difference = 0.0;  ///< delay of y minus delay of x [rad]

  /// Row per electrode: its direction, [[1, 0], [sin(misalignment), cos(misalignment)]].
  Eigen::Matrix2d alignmentMatrix() const;
  /// The same times the gain of each electrode.
  Eigen::Matrix2d gainMatrix() const;
  /// Phase delays of x and y [rad].
  Eigen::Vector2d phaseDelays() const;

  void declare(ParameterTable& table);
};

/// Pick-off: displacement to samples. All errors are off by default.
struct SenseParameters {
  AxisErrors axes;
  double noise_density = 0.0;  ///< white, one-sided [V/sqrt(Hz)]
  double cubic = 0.0;          ///< capacitive gap: x (1 + cubic x^2) [1/V^2]
  double feedthrough = 0.0;    ///< volt in the pick-off per volt of the drive
  std::int64_t adc_bits = 0;   ///< 0: ideal converter
  double adc_range = 2.0;      ///< saturates at +- this [V]; only with adc_bits > 0

  void declare(ParameterTable& table);
};

/// Drive: commanded envelope to force. All errors are off by default.
struct DriveParameters {
  AxisErrors axes;
  double noise_density = 0.0;  ///< white, one-sided [V/sqrt(Hz)]
  double cubic = 0.0;          ///< amplitude error f (1 + cubic f^2) [1/V^2]
  double bias_voltage = 0.0;   ///< square law (7)(8): f + f^2 / (2 bias_voltage); 0: linear [V]
  double gap_cubic = 0.0;      ///< gap that closes: f (1 + gap_cubic x^2) at displacement x [1/V^2]
  bool zero_order_hold = false;  ///< hold each converter sample instead of an ideal modulator
  std::int64_t dac_bits = 0;     ///< 0: ideal; otherwise needs zero_order_hold
  double dac_range = 10.0;       ///< saturates at +- this [V]; only with dac_bits > 0

  void declare(ParameterTable& table);
};

}  // namespace cvg
