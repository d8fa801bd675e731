#include "ring_gyro/identification/filter/paper_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "identification/averaged_loop.h"
#include "identification/recorded_loop.h"
#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

using Filter = PaperFilter<long double>;
using Real = long double;

constexpr double kStep = RecordedLoop::kStep;
const DeviceKnowledge kKnown = RecordedLoop::known();

StateVector someValue() {
  StateVector value;
  value << 1.1, 0.02, 0.02, -0.03, 3e-5, -4e-5, 1.1e5;
  return value;
}

// Of a difference quotient of a and b over `h`, where both values are rounded. In 64 bits or more
// it lies below the tolerances, which stand as they are; long double may be double.
Real roundingOver(Real h) {
  return std::numeric_limits<Real>::epsilon() * someValue().head<2>().norm() / h;
}

Filter someFilter() { return Filter(kKnown, IntervalNoise(), someValue(), StateVector::Ones()); }

AveragedInput someInput() {
  AveragedInput input;
  input.drive = {std::complex<double>(0.3, -0.05), std::complex<double>(0.2, 0.1)};
  input.reference_frequency = kTwoPi * 14000.3;
  input.pattern_rate = -0.2;
  return input;
}

/// The equations as they are printed: at w = w0, phi = -pi/2, a pattern at rest, and the drive (20)
/// of sustain beta and quadrature alpha; the step is so short that Euler's rule is good enough.
TEST(PaperFilter, IsEquations30To33AsPrinted) {
  const StateVector x = someValue();
  const double a = x[0], b = x[1], ks = x[6];
  const double w = kKnown.angularFrequency();
  const double beta = 3.1e-5, alpha = 0.7, dt = 1e-9;
  for (const double theta : {0.0, 0.4, 2.2}) {
    AveragedInput input;
    input.reference_frequency = w;
    // (20) for this orbit: beta multiplies the velocity of both axes.
    const Eigen::Rotation2D<double> turn(theta);
    const std::complex<double> i(0.0, 1.0);
    const Eigen::Vector2cd along(w * beta * a - alpha * b, -i * (w * beta * b - alpha * a));
    input.drive = turn.toRotationMatrix().cast<std::complex<double>>() * along;
    const Filter::Step step = someFilter().step(x.cast<Real>(), theta, -kPi / 2, input, dt);

    const double c = std::cos(2.0 * theta), s = std::sin(2.0 * theta);
    const double d = kKnown.decayRate();
    const double gamma = x[2] * c + x[3] * s, mu = x[4] * s - x[5] * c;
    const double f_a =
        -a * d * (1 + gamma) - b * w / 2 * mu + ks * (a * beta / 2 - b * alpha / (2 * w));
    const double f_b =
        -b * d * (1 - gamma) + a * w / 2 * mu + ks * (b * beta / 2 - a * alpha / (2 * w));
    EXPECT_NEAR(static_cast<double>(step.after[0] - Real(a)) / dt, f_a, 1e-6);
    EXPECT_NEAR(static_cast<double>(step.after[1] - Real(b)) / dt, f_b, 1e-6);
    for (int k = 2; k < 7; ++k) EXPECT_EQ(step.after[k], Real(x[k]));

    // (33), columns gamma1 to ks. The drive is an input, so a and b in it have no derivatives,
    // unlike in (32).
    const double columns[2][5] = {
        {-a * d * c, -a * d * s, -b * w / 2 * s, b * w / 2 * c, a * beta / 2 - b * alpha / (2 * w)},
        {b * d * c, b * d * s, a * w / 2 * s, -a * w / 2 * c, b * beta / 2 - a * alpha / (2 * w)}};
    for (int row = 0; row < 2; ++row) {
      for (int k = 0; k < 5; ++k) {
        const double found = static_cast<double>(step.jacobian(row, k + 2)) / dt;
        EXPECT_NEAR(found, columns[row][k], 1e-6 * std::abs(columns[row][k]) + 1e-9);
      }
    }
    EXPECT_NEAR(static_cast<double>(step.jacobian(0, 0) - 1) / dt, -d * (1 + gamma), 1e-6);
    EXPECT_NEAR(static_cast<double>(step.jacobian(0, 1)) / dt, -w / 2 * mu, 1e-6);
    EXPECT_NEAR(static_cast<double>(step.jacobian(1, 0)) / dt, w / 2 * mu, 1e-6);
    EXPECT_NEAR(static_cast<double>(step.jacobian(1, 1) - 1) / dt, -d * (1 - gamma), 1e-6);
  }
}

TEST(PaperFilter, ItsJacobianIsTheDerivativeOfItsStep) {
  const Filter filter = someFilter();
  const Filter::State x = someValue().cast<Real>();
  const Filter::Step step = filter.step(x, 0.7, -1.5, someInput(), kStep);
  for (int k = 0; k < 7; ++k) {
    const Real h = 1e-6L * std::abs(x[k]);
    Filter::State more = x, less = x;
    more[k] += h;
    less[k] -= h;
    const Filter::State slope = (filter.step(more, 0.7, -1.5, someInput(), kStep).after -
                                 filter.step(less, 0.7, -1.5, someInput(), kStep).after) /
                                (2 * h);
    EXPECT_LT((slope - step.jacobian.col(k)).norm(),
              std::max(1e-9L * slope.norm() + 1e-15L, roundingOver(h)))
        << k;
  }
}

/// Noise of the angles enters through the derivatives of the step with respect to them.
TEST(PaperFilter, NoiseOfTheAnglesActsThroughTheSlopes) {
  IntervalNoise noise;
  noise.angle_density = 1e-10;
  const Filter filter(kKnown, noise, someValue(), StateVector::Ones());
  const Filter::State x = someValue().cast<Real>();
  const double dt = 1e-6, h = 1e-6;
  const auto moved = [&](double theta, double phi) {
    return Filter::Vector2(filter.step(x, theta, phi, someInput(), dt).after.head<2>());
  };
  Filter::Matrix2 slopes;
  slopes.col(0) = (moved(0.7 + h, -1.5) - moved(0.7 - h, -1.5)) / Real(2 * h * dt);
  slopes.col(1) = (moved(0.7, -1.5 + h) - moved(0.7, -1.5 - h)) / Real(2 * h * dt);
  const Filter::Matrix2 expected =
      Real(dt * noise.angle_density) / x.head<2>().squaredNorm() * slopes * slopes.transpose();
  const Filter::Matrix7 found = filter.step(x, 0.7, -1.5, someInput(), dt).noise;
  // Of the order of the rates times dt; each of two factors has the rounding of the slopes.
  const Real tolerance = std::max(1e-5L, 2 * roundingOver(h * dt) / slopes.norm());
  EXPECT_LT((found.topLeftCorner<2, 2>() - expected).norm(), tolerance * expected.norm());
  EXPECT_EQ(found.bottomRightCorner(5, 5).norm(), 0);
}

TEST(PaperFilter, FindsTheDevice) {
  PaperFilter<double> filter(RecordedLoop::known(), RecordedLoop::noise(5e-6, 2e-6),
                             RecordedLoop::startValue(), RecordedLoop::startSigma());
  for (const RecordedStep& record : RecordedLoop(5e-6).next(30000)) {
    filter.predict(record.theta, record.phi, record.input, kStep);
    filter.correct(record.measured);
  }
  const DeviceParameters device = AveragedLoop::Options().device;
  const double truth[] = {device.gamma1, device.gamma2, device.mu1, device.mu2, device.drive_gain};
  for (int k = 0; k < 5; ++k) {
    EXPECT_NEAR(filter.value()[k + 2], truth[k], 4.0 * filter.sigma(k + 2)) << k;
  }
  EXPECT_LT(filter.sigma(2), 1e-5);
}

}  // namespace
}  // namespace cvg
