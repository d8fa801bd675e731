#include "ring_gyro/demodulation/orbit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

double uniform(std::mt19937& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

TEST(Orbit, RoundTripOnRandomOrbitsOfBothBranches) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    Orbit orbit;
    orbit.a = uniform(random, 1e-3, 10.0);
    orbit.b = orbit.a * uniform(random, -0.999, 0.999);
    orbit.theta = uniform(random, -kPi, kPi);
    orbit.phi = uniform(random, -kPi, kPi);  // half of them on the other branch
    const Orbit found = orbitFromEnvelope(envelopeFromOrbit(orbit));
    const bool other_branch = orbit.phi > 0.0;
    const double theta = orbit.theta + (other_branch ? kPi : 0.0);
    const double phi = orbit.phi - (other_branch ? kPi : 0.0);
    ASSERT_NEAR(found.a, orbit.a, 1e-14 * orbit.a);
    ASSERT_NEAR(found.b, orbit.b, 1e-14 * orbit.a);
    ASSERT_NEAR(wrapToPi(found.theta - theta), 0.0, 1e-11);
    ASSERT_NEAR(wrapToPi(found.phi - phi), 0.0, 1e-11);
    ASSERT_GT(found.phi, -kPi);
    ASSERT_LE(found.phi, 0.0);
    ASSERT_LE(std::abs(found.theta), kPi);
    const Eigen::Vector2cd difference = envelopeFromOrbit(found) - envelopeFromOrbit(orbit);
    ASSERT_LT(difference.norm(), 1e-14 * orbit.a);
  }
}

TEST(Orbit, CirclesOfBothSensesGiveTheirEnvelopeBack) {
  for (const double sense : {1.0, -1.0}) {
    const Orbit circle{0.7, sense * 0.7, 0.4, -1.1};
    const Orbit found = orbitFromEnvelope(envelopeFromOrbit(circle));
    EXPECT_NEAR(found.a, 0.7, 1e-15);
    EXPECT_NEAR(found.b, sense * 0.7, 1e-15);
    EXPECT_TRUE(std::isfinite(found.theta) && std::isfinite(found.phi));
    EXPECT_LT((envelopeFromOrbit(found) - envelopeFromOrbit(circle)).norm(), 1e-15);
  }
}

TEST(Orbit, RestIsFinite) {
  const Orbit rest = orbitFromEnvelope(Eigen::Vector2cd::Zero());
  EXPECT_EQ(rest.a, 0.0);
  EXPECT_EQ(rest.b, 0.0);
  EXPECT_TRUE(std::isfinite(rest.theta) && std::isfinite(rest.phi));
}

/// The five quadratic invariants, equation (26) with the sign of L_I corrected [V^2].
struct OrbitInvariants {
  double q = 0.0;    // 2 a b
  double s = 0.0;    // (a^2 - b^2) sin 2 theta
  double r = 0.0;    // (a^2 - b^2) cos 2 theta
  double l_r = 0.0;  // (a^2 - b^2) cos 2 phi
  double l_i = 0.0;  // -(a^2 - b^2) sin 2 phi
};

/// From the demodulated Cx, Sx, Cy, Sy (envelope = C - i S).
OrbitInvariants invariantsFromEnvelope(const Eigen::Vector2cd& envelope) {
  const double cx = envelope[0].real();
  const double sx = -envelope[0].imag();
  const double cy = envelope[1].real();
  const double sy = -envelope[1].imag();
  OrbitInvariants invariants;
  invariants.q = 2.0 * (cx * sy - cy * sx);
  invariants.s = 2.0 * (cx * cy + sx * sy);
  invariants.r = cx * cx + sx * sx - cy * cy - sy * sy;
  invariants.l_r = cx * cx - sx * sx + cy * cy - sy * sy;
  invariants.l_i = 2.0 * (cx * sx + cy * sy);
  return invariants;
}

TEST(Orbit, InvariantsHaveTheSignsOfEquation26) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    Orbit orbit;
    orbit.a = uniform(random, 0.1, 2.0);
    orbit.b = orbit.a * uniform(random, -0.9, 0.9);
    orbit.theta = uniform(random, -kPi, kPi);
    orbit.phi = uniform(random, -kPi, 0.0);
    const OrbitInvariants found = invariantsFromEnvelope(envelopeFromOrbit(orbit));
    const double difference = orbit.a * orbit.a - orbit.b * orbit.b;
    ASSERT_NEAR(found.q, 2.0 * orbit.a * orbit.b, 1e-13);
    ASSERT_NEAR(found.s, difference * std::sin(2.0 * orbit.theta), 1e-13);
    ASSERT_NEAR(found.r, difference * std::cos(2.0 * orbit.theta), 1e-13);
    ASSERT_NEAR(found.l_r, difference * std::cos(2.0 * orbit.phi), 1e-13);
    ASSERT_NEAR(found.l_i, -difference * std::sin(2.0 * orbit.phi), 1e-13);
  }
}

// Equation (15) itself, sampled over a cycle.
TEST(Orbit, EnvelopeIsTheMotionOfEquation15) {
  const Orbit orbit{1.2, -0.3, 0.8, -2.0};
  const Eigen::Vector2cd envelope = envelopeFromOrbit(orbit);
  for (double psi = 0.0; psi < kTwoPi; psi += 0.1) {
    const std::complex<double> turn = std::polar(1.0, psi);
    const double major = orbit.a * std::cos(psi + orbit.phi);
    const double minor = orbit.b * std::sin(psi + orbit.phi);
    const double c = std::cos(orbit.theta);
    const double s = std::sin(orbit.theta);
    EXPECT_NEAR((envelope[0] * turn).real(), c * major - s * minor, 1e-14);
    EXPECT_NEAR((envelope[1] * turn).real(), s * major + c * minor, 1e-14);
  }
}

TEST(AngleUnwrapper, CountsTurnsBothWays) {
  for (const double rate : {0.3, -0.3}) {
    AngleUnwrapper unwrapper;
    double angle = 2.9;
    for (int step = 0; step < 1000; ++step, angle += rate) {
      ASSERT_NEAR(unwrapper.unwrap(wrapToPi(angle)), angle, 1e-9);
    }
  }
}

}  // namespace
}  // namespace cvg
