#pragma once

#include <cstdint>
#include <vector>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// What the extended identifier estimates besides gamma, mu and ks, and the knowledge with which it
/// starts. Each group is switched on separately; docs/observability.md shows which experiment each
/// of them needs.
struct ExtendedParameters {
  double update_period = 0.1;  ///< whole blocks [s]

  bool quality = true;          ///< decay rate xi0 w0
  bool frequency = true;        ///< f0
  bool drive_matrix = false;    ///< phase, gain and phase mismatch of drive and sense path together
  bool drive_rotation = false;  ///< rotation of the drive axes against the sense axes
  bool drift_bias = false;      ///< drift and quadrature that are the same at every angle
  bool sense_matrix = false;    ///< mismatch of the sense path; needs a known rotation
  bool rotation_scale = false;  ///< scale error of the known rotation, that is of k
  bool pickoff_cubic = false;   ///< the pick-off shows x (1 + c x^2) for x
  bool estimate_rotation = false;      ///< the rate of the case, instead of taking it as known
  std::vector<double> even_harmonics;  ///< orders of the drift in the pattern angle
  std::vector<double> odd_harmonics;   ///< orders of the angle scale; needs a known rotation

  double noise_density = 5e-6;           ///< of the displacement samples, one-sided [V/sqrt(Hz)]
  double envelope_process_noise = 1e-7;  ///< of each part of the envelope's rate [V/sqrt(s)]

  double initial_gamma1 = 0.0;
  double initial_gamma2 = 0.0;
  double initial_mu1 = 0.0;
  double initial_mu2 = 0.0;
  double initial_drive_gain = 0.0;  ///< ks; 0: from drive and damping of the first period [1/s^2]
  double initial_cubic = 0.0;       ///< of the pick-off [1/V^2]

  double initial_gamma_sigma = 0.1;
  double initial_mu_sigma = 1e-4;
  double initial_drive_gain_sigma = 0.5;    ///< relative
  double initial_quality_sigma = 0.5;       ///< relative
  double initial_drive_phase_sigma = 0.05;  ///< common and of the axes [rad]
  double initial_mismatch_sigma = 0.05;     ///< of gains, skew and rotation of drive and sense
  double initial_drift_sigma = 0.02;        ///< of the bias and of each harmonic [rad/s]
  double initial_scale_sigma = 0.02;        ///< of each harmonic of the angle scale
  double initial_cubic_sigma = 0.05;        ///< [1/V^2]
  double initial_rotation_sigma = 1.0;      ///< [rad/s]

  double gamma_walk = 0.0;       ///< random walk [1/sqrt(s)]
  double mu_walk = 0.0;          ///< random walk [1/sqrt(s)]
  double drive_gain_walk = 0.0;  ///< random walk, relative [1/sqrt(s)]
  double quality_walk = 0.0;     ///< random walk, relative [1/sqrt(s)]
  double frequency_walk = 0.0;   ///< random walk [Hz/sqrt(s)]
  double drift_walk = 0.0;       ///< random walk of bias and harmonics [rad/s/sqrt(s)]
  double rotation_walk = 0.0;    ///< random walk [rad/s/sqrt(s)]

  /// Blocks in `update_period`. Throws std::invalid_argument when it is not whole.
  std::int64_t periodBlocks(const ConverterParameters& converter) const;

  void declare(ParameterTable& table);
};

}  // namespace cvg
