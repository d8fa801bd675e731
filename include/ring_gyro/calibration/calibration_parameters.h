#pragma once

#include <cstdint>
#include <vector>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Settings of a calibration run. Rates are those of steering unless noted; times do not include
/// the settling before each leg.
struct CalibrationRunParameters {
  double survey_rate = 0.0;           ///< of the survey; 0: 0.3 xi0 w0 [rad/s]
  double rate_margin = 4.0;           ///< steering rate over the drift xi0 w0 |gamma| of the survey
  double least_rate = 0.2;            ///< smallest steering rate, however small the drift [rad/s]
  double settling_decays = 10.0;      ///< before each leg, in decay times 1/(xi0 w0)
  double identification_time = 60.0;  ///< at each sign of the rate [s]
  std::int64_t identification_rounds = 2;
  double amplitude_modulation = 0.1;            ///< while identifying, relative
  double amplitude_modulation_frequency = 0.5;  ///< [Hz]
  double drift_time = 60.0;        ///< at each sign, in all drift rounds but the last [s]
  double last_drift_time = 600.0;  ///< at each sign, in the last round [s]
  std::int64_t drift_rounds = 3;
  double drift_rate = 0.1;  ///< of steering in the drift rounds, with gamma cancelled [rad/s]
  std::int64_t highest_order = 8;  ///< of drift and angle map in the pattern angle
  bool rate_table = true;          ///< stage two: the case can be turned
  double table_rate = 1.0;         ///< of the case while the angle map is measured [rad/s]
  double table_time = 300.0;       ///< at each sign [s]
  std::vector<double> verification_rates = {0.0872664626, 0.2094395102, 0.6981317008};  ///< [rad/s]
  double verification_time = 150.0;  ///< at each rate and sign [s]
  double threshold_time = 60.0;      ///< of the test at twice the threshold [s]

  void declare(ParameterTable& table);
};

}  // namespace cvg
