#include "ring_gyro/demodulation/demodulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <random>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

double rejection(const ConverterParameters& converter, double resonance) {
  const auto taps = demodulationFilter(converter, resonance, 120.0);
  double largest = 0.0;
  for (double share = 0.98; share <= 1.02; share += 1e-3) {
    largest = std::max(largest, filterGain(taps, 2.0 * resonance * share, converter.sample_rate));
  }
  return -20.0 * std::log10(largest);
}

TEST(DemodulationFilter, RejectsTwiceTheReferenceBy120Decibel) {
  for (const double resonance : {3e3, 14.000e3, 14.195e3, 25e3}) {
    const double found = rejection({}, resonance);
    std::printf("[figure] rejection of 2w at %.3f kHz: %.1f dB (must 120)\n", 1e-3 * resonance,
                found);
    EXPECT_GT(found, 120.0);
  }
  ConverterParameters fast;
  fast.sample_rate = 800e3;
  fast.block_samples = 800;
  EXPECT_GT(rejection(fast, 100e3), 120.0);
}

TEST(DemodulationFilter, HasUnitGainAtDcZerosAtTheBlockRateAndSymmetry) {
  const ConverterParameters converter;
  const auto taps = demodulationFilter(converter, 14e3, 120.0);
  EXPECT_NEAR(filterGain(taps, 0.0, converter.sample_rate), 1.0, 1e-14);
  for (double block_rate = 1e3; block_rate < 10e3; block_rate += 1e3) {
    EXPECT_LT(filterGain(taps, block_rate, converter.sample_rate), 1e-13);
  }
  for (std::size_t j = 0; j < taps.size(); ++j) {
    ASSERT_NEAR(taps[j], taps[taps.size() - 1 - j], 1e-16);
  }
}

TEST(DemodulationFilter, RefusesASampleRateTooLow) {
  EXPECT_THROW(demodulationFilter({}, 60e3, 120.0), std::invalid_argument);
}

// A signal pair of known envelope against a reference that changes its frequency each block.
struct Signal {
  Complex x{0.3, -0.7};
  Complex y{-0.2, 0.1};
  double drift = 3.0;  // of the envelope's phase [rad/s]
};

DisplacementBlock blockOf(const ConverterParameters& converter, const Signal& signal,
                          std::uint64_t sequence, double phase, double frequency) {
  DisplacementBlock block;
  block.stamp.sequence = sequence;
  block.stamp.duration_ns = converter.blockDurationNanoseconds();
  block.reference_phase = phase;
  block.reference_frequency = frequency;
  const auto samples = static_cast<std::size_t>(converter.block_samples);
  for (std::size_t j = 0; j < samples; ++j) {
    const double offset = converter.samplePeriod() * static_cast<double>(j);
    const double time = converter.blockDuration() * static_cast<double>(sequence) + offset;
    const Complex turn = std::polar(1.0, phase + frequency * offset + signal.drift * time);
    block.x.push_back((signal.x * turn).real());
    block.y.push_back((signal.y * turn).real());
  }
  return block;
}

TEST(Demodulator, FindsTheEnvelopeAtItsGroupDelay) {
  const ConverterParameters converter;
  Demodulator demodulator({}, converter, 14e3);
  const Signal signal;
  double phase = 0.4;
  double largest = 0.0;
  for (std::uint64_t n = 0; n < 500; ++n) {
    const double frequency = kTwoPi * (14e3 + 0.5 * std::sin(0.05 * static_cast<double>(n)));
    const Eigen::Vector2cd found =
        demodulator.process(blockOf(converter, signal, n, phase, frequency));
    phase = wrapToPi(phase + frequency * converter.blockDuration());
    if (n < 2) continue;
    const double time =
        converter.blockDuration() * static_cast<double>(n + 1) - demodulator.groupDelay();
    const Complex turn = std::polar(1.0, signal.drift * time);
    largest = std::max(
        {largest, std::abs(found[0] - signal.x * turn), std::abs(found[1] - signal.y * turn)});
  }
  // The filter's curvature, (drift * its width)^2 / 24, is 3e-7; 2w leaves less than 1e-6.
  EXPECT_LT(largest, 1e-6);
}

TEST(Demodulator, KeepsTheNoiseDensityOfTheSamples) {
  const ConverterParameters converter;
  Demodulator demodulator({}, converter, 14.195e3);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const double density = 5e-6;  // [V/sqrt(Hz)]
  const double sigma = density * std::sqrt(0.5 * converter.sample_rate);
  const int blocks = 20000;
  const int grouped = 20;
  double sum = 0.0;
  Eigen::Vector2cd group = Eigen::Vector2cd::Zero();
  for (int n = 0; n < blocks; ++n) {
    DisplacementBlock block;
    block.stamp.sequence = static_cast<std::uint64_t>(n);
    block.reference_frequency = kTwoPi * 14.195e3;
    block.reference_phase = wrapToPi(block.reference_frequency * converter.blockDuration() * n);
    for (std::int64_t j = 0; j < converter.block_samples; ++j) {
      block.x.push_back(sigma * normal(random));
      block.y.push_back(sigma * normal(random));
    }
    group += demodulator.process(block);
    if ((n + 1) % grouped != 0) continue;
    sum += group.squaredNorm() / (grouped * grouped);
    group.setZero();
  }
  // Each of four quadratures has the two-sided density squared density^2: variance density^2 / T.
  const double expected = 4.0 * density * density / (grouped * converter.blockDuration());
  EXPECT_NEAR(sum / (blocks / grouped) / expected, 1.0, 0.06);  // 4000 squares: 2.2 % sigma
}

}  // namespace
}  // namespace cvg
