#pragma once

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// The vibrating ring as its electronics see it, equations (6)-(10) with the errata of
/// docs/derivation.md:
///
///     x'' + 2 xi0 w0 [(1+g1) x' + g2 y'] + w0^2 [(1+m1) x + m2 y] = ks fx + 2 k Om y'
///     y'' + 2 xi0 w0 [g2 x' + (1-g1) y'] + w0^2 [m2 x + (1-m1) y] = ks fy - 2 k Om x'
struct ResonatorParameters {
  double natural_frequency = 0.0;      ///< w0 / 2 pi [Hz]
  double quality_factor = 0.0;         ///< Q = 1 / (2 xi0)
  double gamma1 = 0.0;                 ///< damping mismatch along the axes
  double gamma2 = 0.0;                 ///< damping mismatch across the axes
  double mu1 = 0.0;                    ///< stiffness mismatch along the axes
  double mu2 = 0.0;                    ///< stiffness mismatch across the axes
  double drive_gain = 0.0;             ///< ks, sensed acceleration per drive volt [1/s^2]
  double angular_gain = 1.0;           ///< k, the Bryan factor
  double cubic_stiffness = 0.0;        ///< relative stiffness per V^2: w0^2 c (x^2 + y^2) [1/V^2]
  double thermal_noise_density = 0.0;  ///< thermo-mechanical force noise, as drive [V/sqrt(Hz)]

  // Capacitors, equations (7)-(9): given instead of drive_gain, or all zero.
  double bias_voltage = 0.0;           ///< Vdc [V]
  double electrode_gap = 0.0;          ///< d [m]
  double electrode_capacitance = 0.0;  ///< C0 [F]
  double feedback_capacitance = 0.0;   ///< CF of the charge amplifier [F]
  double modal_mass = 0.0;             ///< m [kg]

  // Electrostatic tuning, second term of (8): an electrode at voltage V reduces the stiffness along
  // its direction by tuning_gain V^2 w0^2. Directions in the plane of x and y: 0, 90, 45, 135
  // degrees.
  double tuning_gain = 0.0;         ///< C / (d^2 m w0^2) of a tuning electrode [1/V^2]
  double tuning_voltage_0 = 0.0;    ///< lowers mu1 [V]
  double tuning_voltage_90 = 0.0;   ///< raises mu1 [V]
  double tuning_voltage_45 = 0.0;   ///< lowers mu2 [V]
  double tuning_voltage_135 = 0.0;  ///< raises mu2 [V]

  // Slow drift with temperature, linear in the deviation temperature_rate * t.
  double temperature_rate = 0.0;                   ///< [K/s]
  double frequency_temperature_coefficient = 0.0;  ///< relative, of w0 [1/K]
  double quality_temperature_coefficient = 0.0;    ///< relative, of Q [1/K]
  double gamma_temperature_coefficient = 0.0;      ///< relative, of gamma1 and gamma2 [1/K]

  double angularFrequency() const { return kTwoPi * natural_frequency; }    ///< w0 [rad/s]
  double dampingRatio() const { return 0.5 / quality_factor; }              ///< xi0
  double decayRate() const { return dampingRatio() * angularFrequency(); }  ///< xi0 w0 [1/s]

  /// ks [1/s^2]: drive_gain, or eta_d eta_s / (m CF) with eta = Vdc C0 / d when the capacitors are
  /// given. Throws std::invalid_argument when neither or both are given, or some capacitor values
  /// are missing.
  double driveGain() const;

  /// The same ring with the effect of its tuning voltages included in f0, Q, mu1 and mu2.
  /// Throws std::invalid_argument when the voltages would make it unstable (pull-in).
  ResonatorParameters tuned() const;

  void declare(ParameterTable& table);
};

}  // namespace cvg
