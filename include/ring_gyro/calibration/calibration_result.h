#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/common/angle_harmonics.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/signals/corrections.h"

namespace cvg {

/// A parameter of the device found by the extended identifier.
struct IdentifiedParameter {
  std::string name;
  double value = 0.0;
  double sigma = 0.0;
};

/// Drift against angle, measured by steering one way and the other.
struct DriftRound {
  AngleHarmonics measured;    ///< drift left by the acting corrections [rad/s]
  AngleHarmonics total;       ///< the same plus the drift that they cancel [rad/s]
  double peak_to_peak = 0.0;  ///< of `measured` [rad/s]
  double sigma = 0.0;         ///< of a coefficient of `measured`, from turn to turn [rad/s]
};

/// The calibrated gyroscope at one rate and its opposite. All rates are those of the case, as the
/// gyroscope reports them (the pattern turns k times as fast); without a rate table, of the
/// pattern.
struct Verification {
  double rate = 0.0;           ///< of the case, or of steering without a rate table [rad/s]
  double forward_peak = 0.0;   ///< harmonics of the output rate, peak to peak [rad/s]
  double backward_peak = 0.0;  ///< the same at the opposite rate [rad/s]
  double forward_scale = 0.0;  ///< mean output rate over the commanded rate, minus one
  double backward_scale = 0.0;
  AngleHarmonics drift;             ///< even part [rad/s]
  double drift_peak_to_peak = 0.0;  ///< [rad/s]
};

/// Test whether the angle follows a rate of twice the threshold, starting at the worst angle.
struct ThresholdTest {
  double threshold = 0.0;    ///< rate of the case that the largest |drift| can hide [rad/s]
  double worst_angle = 0.0;  ///< [rad]
  double rate = 0.0;    ///< of the case in the test, twice the threshold against the drift [rad/s]
  double turned = 0.0;  ///< of the output angle [rad]
  double expected = 0.0;  ///< of a gyroscope without drift [rad]
  /// It turned in the right direction, by at least half of the expected angle.
  bool followed() const { return turned * expected > 0.0 && turned / expected >= 0.5; }
};

/// All results of a calibration run.
struct CalibrationResult {
  Corrections corrections;  ///< with the gains of `device`
  /// f0, Q and ks as identified; k from the rate table, without one the nominal k.
  DeviceKnowledge device;
  double steering_rate = 0.0;                   ///< that the survey chose [rad/s]
  std::vector<IdentifiedParameter> parameters;  ///< of the last identification
  std::vector<DriftRound> drift_rounds;
  bool angle_map_measured = false;
  AngleHarmonics table_drift;  ///< even part while the map was measured [rad/s]
  std::vector<Verification> verifications;
  std::optional<ThresholdTest> threshold;
  double duration = 0.0;             ///< of the run [s]
  std::vector<std::string> missing;  ///< stages not done yet; empty: the result is complete
};

}  // namespace cvg
