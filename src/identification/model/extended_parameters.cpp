#include "ring_gyro/identification/model/extended_parameters.h"

namespace cvg {

std::int64_t ExtendedParameters::periodBlocks(const ConverterParameters& converter) const {
  return converter.wholeBlocks(update_period, "extended/update_period");
}

void ExtendedParameters::declare(ParameterTable& table) {
  const Range order = Range::between(1.0, 16.0);
  const Range walk = Range::atLeast(0.0);
  table
      .number("update_period", update_period, "s", Range::between(1e-6, 10.0),
              "a whole number of blocks; their mean is one measurement")
      .flag("quality", quality, "estimate Q; then Q need not be known, and ks is absolute")
      .flag("frequency", frequency, "estimate f0; off: natural_frequency of device is exact")
      .flag("drive_matrix", drive_matrix,
            "estimate phase, gain and phase mismatch of the drive times sense path")
      .flag("drive_rotation", drive_rotation,
            "estimate the turn of the drive against the sense axes, and its phase")
      .flag("drift_bias", drift_bias,
            "estimate drift and quadrature that are the same at every pattern angle")
      .flag("sense_matrix", sense_matrix,
            "estimate gain and phase mismatch of the sense path; needs a known rotation")
      .flag("rotation_scale", rotation_scale,
            "estimate the scale of the known rotation: an angular gain that differs from the "
            "configured one")
      .flag("pickoff_cubic", pickoff_cubic, "estimate c of a pick-off that reads x (1 + c x^2)")
      .flag("estimate_rotation", estimate_rotation,
            "estimate the rotation of the case instead of taking it as known")
      .numbers("even_harmonics", even_harmonics, "1", order,
               "orders in the pattern angle of the drift to estimate")
      .numbers("odd_harmonics", odd_harmonics, "1", order,
               "orders of the angle scale to estimate; need a known rotation")
      .number("noise_density", noise_density, "V/sqrt(Hz)", Range::between(1e-12, 1.0),
              "of the displacement samples, white, one-sided")
      .number("envelope_process_noise", envelope_process_noise, "V/sqrt(s)",
              Range::between(0.0, 1.0),
              "white noise of each part of the envelope's rate: thermo-mechanical noise and "
              "effects that are not in the model")
      .number("initial_gamma1", initial_gamma1, "1", Range::between(-1.0, 1.0),
              "start value of gamma1")
      .number("initial_gamma2", initial_gamma2, "1", Range::between(-1.0, 1.0),
              "start value of gamma2")
      .number("initial_mu1", initial_mu1, "1", Range::between(-0.01, 0.01), "start value of mu1")
      .number("initial_mu2", initial_mu2, "1", Range::between(-0.01, 0.01), "start value of mu2")
      .number("initial_drive_gain", initial_drive_gain, "1/s^2", Range::atLeast(0.0),
              "start value of ks; 0: from the balance of drive and damping")
      .number("initial_cubic", initial_cubic, "1/V^2", Range::between(-10.0, 10.0),
              "start value of the cubic term of the pick-off")
      .number("initial_gamma_sigma", initial_gamma_sigma, "1", Range::between(1e-9, 1.0),
              "sigma of gamma1 and gamma2 before any data")
      .number("initial_mu_sigma", initial_mu_sigma, "1", Range::between(1e-12, 1e-2),
              "sigma of mu1 and mu2 before any data; also sets the sigma of f0")
      .number("initial_drive_gain_sigma", initial_drive_gain_sigma, "1",
              Range::between(1e-9, 100.0), "relative sigma of ks before any data")
      .number("initial_quality_sigma", initial_quality_sigma, "1", Range::between(1e-9, 10.0),
              "relative sigma of Q before any data")
      .number("initial_drive_phase_sigma", initial_drive_phase_sigma, "rad",
              Range::between(1e-9, 1.0), "sigma of the phases of the drive matrix before any data")
      .number("initial_mismatch_sigma", initial_mismatch_sigma, "1", Range::between(1e-9, 1.0),
              "sigma of gain mismatch, skew and rotation of drive and sense before any data")
      .number("initial_drift_sigma", initial_drift_sigma, "rad/s", Range::between(1e-9, 10.0),
              "sigma of the drift bias and each of its harmonics before any data")
      .number("initial_scale_sigma", initial_scale_sigma, "1", Range::between(1e-9, 1.0),
              "sigma of each harmonic of the angle scale before any data")
      .number("initial_cubic_sigma", initial_cubic_sigma, "1/V^2", Range::between(1e-9, 10.0),
              "sigma of the cubic term of the pick-off before any data")
      .number("initial_rotation_sigma", initial_rotation_sigma, "rad/s",
              Range::between(1e-9, 100.0), "sigma of the rotation of the case before any data")
      .number("gamma_walk", gamma_walk, "1/sqrt(s)", walk,
              "random walk of gamma1 and gamma2; 0: constant")
      .number("mu_walk", mu_walk, "1/sqrt(s)", walk, "random walk of mu1 and mu2; 0: constant")
      .number("drive_gain_walk", drive_gain_walk, "1/sqrt(s)", walk,
              "random walk of ks, relative; 0: constant")
      .number("quality_walk", quality_walk, "1/sqrt(s)", walk,
              "random walk of Q, relative; 0: constant")
      .number("frequency_walk", frequency_walk, "Hz/sqrt(s)", walk,
              "random walk of f0; 0: constant")
      .number("drift_walk", drift_walk, "rad/s/sqrt(s)", walk,
              "random walk of the drift bias and its harmonics; 0: constant")
      .number("rotation_walk", rotation_walk, "rad/s/sqrt(s)", walk,
              "random walk of the estimated rotation; 0: constant");
}

}  // namespace cvg
