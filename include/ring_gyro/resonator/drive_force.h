#pragma once

#include <Eigen/Core>
#include <complex>

namespace cvg {

/// Drive that reaches the ring from an ideal modulator, by harmonics of the reference phase psi
/// [V]: f(t) = constant + Re[fundamental e^{i psi} + second e^{2 i psi}].
///
/// The constant and the second harmonic come from the electrode's square law, equations (7) and
/// (8): the force of an electrode at V_bias + f is proportional to (V_bias + f)^2, so a drive f
/// acts as f + f^2 / (2 V_bias).
struct DriveForce {
  DriveForce() = default;
  DriveForce(const Eigen::Vector2cd& phasor) : fundamental(phasor) {}  // NOLINT: a plain drive

  bool harmonic() const { return constant.isZero(0.0) && second.isZero(0.0); }
  /// Value [V] at a reference phase [rad].
  Eigen::Vector2d at(double phase) const {
    const std::complex<double> turn = std::polar(1.0, phase);
    return constant + (fundamental * turn + second * (turn * turn)).real();
  }

  Eigen::Vector2cd fundamental = Eigen::Vector2cd::Zero();
  Eigen::Vector2d constant = Eigen::Vector2d::Zero();
  Eigen::Vector2cd second = Eigen::Vector2cd::Zero();
};

/// Steady motion of the ring under a DriveForce: displacement phasors [V], frequency of the
/// reference [rad/s].
struct ForcedMotion {
  Eigen::Vector2cd fundamental = Eigen::Vector2cd::Zero();
  Eigen::Vector2d constant = Eigen::Vector2d::Zero();
  Eigen::Vector2cd second = Eigen::Vector2cd::Zero();
  bool harmonic = true;  ///< the constant and the second harmonic are zero
  double frequency = 0.0;

  /// Displacements and velocities [V, V, V/s, V/s] at a reference phase [rad].
  Eigen::Vector4d at(double phase) const { return atTurn(std::polar(1.0, phase)); }
  /// The same for `turn` = e^{i phase}.
  Eigen::Vector4d atTurn(const std::complex<double>& turn) const {
    const Eigen::Vector2cd first = fundamental * turn;
    Eigen::Vector4d state;
    state << first.real(), -frequency * first.imag();
    if (!harmonic) {
      const Eigen::Vector2cd twice = second * (turn * turn);
      state.head<2>() += constant + twice.real();
      state.tail<2>() -= 2.0 * frequency * twice.imag();
    }
    return state;
  }
};

}  // namespace cvg
