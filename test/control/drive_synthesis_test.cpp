#include "ring_gyro/control/drive_synthesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

const Orbit kOrbit{0.9, 0.02, 0.7, -0.5 * kPi};
constexpr double kFrequency = kTwoPi * 14e3;
constexpr double kDriveGain = 1.1e5;

// Equation (28) written out, with sin and cos of the NCO phase.
TEST(DriveSynthesis, SustainAndQuadratureAreEquation28) {
  DriveGains gains;
  gains.sustain_force = 3.2;
  gains.alpha = -2.5;
  const Eigen::Vector2cd drive = synthesizeDrive(kOrbit, gains, kFrequency, kDriveGain).total();
  const double beta_hat = gains.sustain_force / kOrbit.a;  // w beta
  const double s = std::sin(kOrbit.theta);
  const double c = std::cos(kOrbit.theta);
  for (double psi = 0.0; psi < kTwoPi; psi += 0.3) {
    const double minor = -beta_hat * kOrbit.b + gains.alpha * kOrbit.a;
    const double major = beta_hat * kOrbit.a - gains.alpha * kOrbit.b;
    const double fx = minor * s * std::sin(psi) + major * c * std::cos(psi);
    const double fy = -minor * c * std::sin(psi) + major * s * std::cos(psi);
    const Complex turn = std::polar(1.0, psi);
    EXPECT_NEAR((drive[0] * turn).real(), fx, 1e-13);
    EXPECT_NEAR((drive[1] * turn).real(), fy, 1e-13);
  }
}

TEST(DriveSynthesis, SteeringIsTheCoriolisForceOfTheVirtualRate) {
  DriveGains gains;
  gains.virtual_rate = 0.2;
  const Eigen::Vector2cd drive = synthesizeDrive(kOrbit, gains, kFrequency, kDriveGain).steering;
  const Eigen::Vector2cd velocity = velocityEnvelope(kOrbit, kFrequency);
  // ks f = (2 Om y', -2 Om x')
  EXPECT_NEAR(std::abs(kDriveGain * drive[0] - 0.4 * velocity[1]), 0.0, 1e-9);
  EXPECT_NEAR(std::abs(kDriveGain * drive[1] + 0.4 * velocity[0]), 0.0, 1e-9);
}

TEST(DriveSynthesis, VelocityIsTheDerivativeOfTheLockedMotion) {
  const Eigen::Vector2cd displacement = envelopeFromOrbit(kOrbit);
  const Eigen::Vector2cd velocity = velocityEnvelope(kOrbit, kFrequency);
  EXPECT_LT((velocity - Complex(0.0, kFrequency) * displacement).norm(), 1e-9);
}

TEST(DriveSynthesis, NeedsTheBranchThatTheElementsPick) {
  // (theta + pi, phi + pi) is the same motion, but the synthesis takes phi = -pi/2 for granted: on
  // the other branch the drive has the wrong sign, which is why orbitFromEnvelope picks the branch.
  Orbit other = kOrbit;
  other.theta += kPi;
  DriveGains gains;
  gains.sustain_force = 1.0;
  const Eigen::Vector2cd right = synthesizeDrive(kOrbit, gains, kFrequency, kDriveGain).sustain;
  const Eigen::Vector2cd wrong = synthesizeDrive(other, gains, kFrequency, kDriveGain).sustain;
  EXPECT_LT((right + wrong).norm(), 1e-12);
  other.phi += kPi;
  const Orbit picked = orbitFromEnvelope(envelopeFromOrbit(other));
  const Eigen::Vector2cd again = synthesizeDrive(picked, gains, kFrequency, kDriveGain).sustain;
  EXPECT_LT((right - again).norm(), 1e-12);
}

}  // namespace
}  // namespace cvg
