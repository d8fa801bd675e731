#include "ring_gyro/analysis/rate_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr double kPeriod = 1e-3;

/// Steering at `rate` with a drift that depends on the angle.
struct Drift {
  double rate = toRadians(-12.0);
  double second = toRadians(4.115);
  double second_phase = 0.7;
  double fourth = 0.0;

  double operator()(double theta) const {
    return rate + second * std::cos(2.0 * theta - second_phase) + fourth * std::sin(4.0 * theta);
  }
};

/// Solves theta' = drift(theta) by Runge-Kutta steps of one sample: error far below 1e-12 rad.
std::vector<AngleSample> integrate(const Drift& drift, double duration, double theta = 0.3) {
  std::vector<AngleSample> samples;
  const int count = static_cast<int>(std::lround(duration / kPeriod));
  for (int i = 0; i <= count; ++i) {
    samples.push_back({5.0 + i * kPeriod, theta});
    const double k1 = drift(theta);
    const double k2 = drift(theta + 0.5 * kPeriod * k1);
    const double k3 = drift(theta + 0.5 * kPeriod * k2);
    const double k4 = drift(theta + kPeriod * k3);
    theta += kPeriod / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return samples;
}

/// White noise of the angle as 5 uV/sqrt(Hz) on a 1 V orbit gives it at 1 kHz.
void addNoise(std::vector<AngleSample>& samples, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> noise(0.0, 5e-6 * std::sqrt(2.0) * std::sqrt(0.5 / kPeriod));
  for (AngleSample& sample : samples) sample.theta += noise(generator);
}

TEST(RateHarmonics, recoversMeanAmplitudeAndPhase) {
  Drift drift;
  drift.fourth = toRadians(0.43);
  const RateHarmonics fit = fitRateHarmonics(integrate(drift, 65.0));
  EXPECT_NEAR(fit.mean_rate, drift.rate, 1e-9);
  EXPECT_NEAR(fit.amplitude(2), drift.second, 1e-8);
  EXPECT_NEAR(fit.phase(2), drift.second_phase, 1e-7);
  EXPECT_NEAR(fit.sine[3], drift.fourth, 1e-8);
  for (int n : {1, 3, 5, 6, 7, 8}) EXPECT_LT(fit.amplitude(n), 1e-8) << n;
  EXPECT_LT(fit.residual_rms, 1e-8);
  EXPECT_EQ(fit.whole_turns, 2);
}

TEST(RateHarmonics, doesNotDependOnTheWindow) {
  Drift drift;
  drift.fourth = toRadians(0.43);
  const auto samples = integrate(drift, 65.0);
  for (double window : {0.01, 0.05, 0.1, 0.5}) {
    const RateHarmonics fit = fitRateHarmonics(samples, window);
    EXPECT_NEAR(fit.amplitude(2), drift.second, 1e-7) << window;
    EXPECT_NEAR(fit.amplitude(4), drift.fourth, 1e-7) << window;
  }
}

TEST(RateHarmonics, peakToPeakIsOfTheHarmonics) {
  Drift drift;
  const RateHarmonics second = fitRateHarmonics(integrate(drift, 65.0));
  EXPECT_NEAR(second.peak_to_peak, 2.0 * drift.second, 1e-7);
  EXPECT_NEAR(second.rate(1.234), drift(1.234), 1e-7);
}

TEST(RateHarmonics, bothSensesOfRotation) {
  Drift drift;
  drift.rate = -drift.rate;
  const RateHarmonics fit = fitRateHarmonics(integrate(drift, 65.0));
  EXPECT_NEAR(fit.mean_rate, drift.rate, 1e-9);
  EXPECT_NEAR(fit.amplitude(2), drift.second, 1e-8);
}

TEST(RateHarmonics, noiseOverAMinuteCostsUnderAThousandthOfADegreePerSecond) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Drift large;
    auto samples = integrate(large, 65.0);
    addNoise(samples, seed);
    EXPECT_NEAR(toDegrees(fitRateHarmonics(samples).peak_to_peak), 2.0 * toDegrees(large.second),
                1e-3);
    Drift none;
    none.second = 0.0;
    samples = integrate(none, 65.0);
    addNoise(samples, 100 + seed);
    const RateHarmonics fit = fitRateHarmonics(samples);
    // Of nothing but noise, sixteen coefficients leave a peak-to-peak that cannot be negative.
    EXPECT_LT(toDegrees(fit.peak_to_peak), 1.8e-3);
    EXPECT_NEAR(fit.mean_rate / none.rate, 1.0, 1e-5);
  }
}

TEST(RateHarmonics, usesTheLastWholeTurns) {
  Drift steady;
  steady.second = 0.0;
  auto samples = integrate(steady, 100.0);
  const RateHarmonics fit = fitRateHarmonics(samples);
  EXPECT_EQ(fit.whole_turns, 3);
  EXPECT_NEAR(fit.begin_time, 5.0 + 10.0, 2e-3);
  EXPECT_NEAR(fit.end_time, 105.0, 1e-9);
}

TEST(RateHarmonics, missingSamplesDoNotBias) {
  Drift drift;
  auto samples = integrate(drift, 65.0);
  samples.erase(samples.begin() + 20000, samples.begin() + 20777);
  samples.erase(samples.begin() + 40000);
  const RateHarmonics fit = fitRateHarmonics(samples);
  EXPECT_NEAR(fit.mean_rate, drift.rate, 1e-8);
  EXPECT_NEAR(fit.amplitude(2), drift.second, 1e-7);
}

TEST(RateHarmonics, refusesWhatItCannotFit) {
  Drift drift;
  EXPECT_THROW(fitRateHarmonics({}), std::invalid_argument);
  EXPECT_THROW(fitRateHarmonics({{0.0, 0.0}}), std::invalid_argument);
  EXPECT_THROW(fitRateHarmonics(integrate(drift, 20.0)), std::invalid_argument);
  EXPECT_THROW(fitRateHarmonics(integrate(drift, 65.0), 1e-3), std::invalid_argument);
  EXPECT_THROW(fitRateHarmonics(integrate(drift, 65.0), 5.0), std::invalid_argument);
  auto samples = integrate(drift, 65.0);
  samples[30].theta = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fitRateHarmonics(samples), std::invalid_argument);
  samples = integrate(drift, 65.0);
  samples[30].time = samples[29].time;
  EXPECT_THROW(fitRateHarmonics(samples), std::invalid_argument);
}

TEST(WindowedRates, areTheRateAtTheMeanAngle) {
  Drift drift;
  const auto rates = windowedRates(integrate(drift, 10.0));
  ASSERT_EQ(rates.size(), 99u);
  for (const RateSample& sample : rates) {
    EXPECT_NEAR(sample.rate, drift(sample.theta), 3e-5);
  }
  EXPECT_NEAR(rates.front().time, 5.0 + 0.0995, 1e-9);
}

}  // namespace
}  // namespace cvg
