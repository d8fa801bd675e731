#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {

/// Response of both pick-offs (rows) to both drives (columns) at one frequency, volt per volt.
struct FrequencyPoint {
  double frequency = 0.0;  ///< [Hz]
  Eigen::Matrix2cd response = Eigen::Matrix2cd::Zero();
};

/// One mode of the ring.
struct VibrationMode {
  double frequency = 0.0;       ///< [Hz]
  double quality_factor = 0.0;  ///< Q
};

/// What a frequency response shows of a device.
struct FrequencyResponseFit {
  double natural_frequency = 0.0;      ///< f0, of the ring without mismatch [Hz]
  double quality_factor = 0.0;         ///< Q, of the ring without mismatch
  DeviceParameters device;             ///< gamma, mu and ks of the fit to the whole matrix
  double phase_delay = 0.0;            ///< common to all paths, of the electronics [rad]
  std::array<VibrationMode, 2> modes;  ///< lower frequency first
  double split = 0.0;                  ///< of the modes [Hz]
  double drive_gain_peak = 0.0;        ///< ks by (34), from the peak of x / drive x [1/s^2]
  double residual = 0.0;               ///< rms misfit relative to the response
};

/// Fits K, C and ks in ks H(w)^-1 = K - w^2 + i w C to the measured matrices, by linear least
/// squares weighted by the response; a phase common to all paths appears as the phase of 1/ks.
/// Needs five points around the resonance; throws std::invalid_argument otherwise.
FrequencyResponseFit fitFrequencyResponse(const std::vector<FrequencyPoint>& points);

/// Free decays: equally spaced envelopes [V], relative to a reference of `frequency` [Hz]. Each run
/// starts from a different motion.
struct RingDown {
  double frequency = 0.0;
  double period = 0.0;  ///< between envelopes [s]
  std::vector<std::vector<Eigen::Vector2cd>> runs;
};

/// Modes, lower frequency first, from E(t + period) = e^{D period} E(t) in all runs: the
/// eigenvalues of D are -w / 2Q + i (w - reference). The runs must excite both modes; throws
/// std::invalid_argument when they do not, or when no motion decays.
std::array<VibrationMode, 2> fitRingDown(const RingDown& ring_down);

}  // namespace cvg
