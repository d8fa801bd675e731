#include "ring_gyro/demodulation/demodulator.h"

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/vector_kernels.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

std::vector<double> kaiserWindow(std::size_t length, double shape) {
  std::vector<double> window(length);
  const double middle = 0.5 * static_cast<double>(length - 1);
  for (std::size_t j = 0; j < length; ++j) {
    const double position = middle > 0.0 ? (static_cast<double>(j) - middle) / middle : 0.0;
    const double inside = std::sqrt(std::max(0.0, 1.0 - position * position));
    window[j] = boost::math::cyl_bessel_i(0, shape * inside);
  }
  return window;
}

std::vector<double> convolved(const std::vector<double>& one, const std::vector<double>& other) {
  std::vector<double> result(one.size() + other.size() - 1, 0.0);
  for (std::size_t j = 0; j < one.size(); ++j) {
    for (std::size_t k = 0; k < other.size(); ++k) result[j + k] += one[j] * other[k];
  }
  return result;
}

}  // namespace

void DemodulationParameters::declare(ParameterTable& table) {
  table.number("stopband_attenuation", stopband_attenuation, "dB", Range::between(40.0, 160.0),
               "required rejection at twice the reference frequency");
}

double filterGain(const std::vector<double>& taps, double frequency, double sample_rate) {
  Complex sum = 0.0;
  for (std::size_t j = 0; j < taps.size(); ++j) {
    sum += taps[j] * std::polar(1.0, -kTwoPi * frequency / sample_rate * static_cast<double>(j));
  }
  return std::abs(sum);
}

std::vector<double> demodulationFilter(const ConverterParameters& converter, double frequency,
                                       double attenuation) {
  if (4.0 * frequency > converter.sample_rate) {
    throw std::invalid_argument(
        "converter: sample_rate = " + std::to_string(converter.sample_rate) +
        " Hz must be at least 4 times the natural frequency " + std::to_string(frequency) +
        " Hz, or twice that frequency cannot be rejected");
  }
  const std::vector<double> average(static_cast<std::size_t>(converter.block_samples), 1.0);
  // A Kaiser window of shape b and length n as a smoother: sidelobes about 10 + 6.8 b dB down
  // beyond the edge sqrt(pi^2 + b^2) 2 / (n - 1). The edge is set well below twice the frequency.
  const double shape = attenuation / 6.8;
  const double edge = 0.8 * kTwoPi * 2.0 * frequency / converter.sample_rate;
  const auto length = static_cast<std::size_t>(std::ceil(2.0 * std::hypot(kPi, shape) / edge)) + 1;
  std::vector<double> taps = convolved(average, kaiserWindow(length, shape));
  double sum = 0.0;
  for (double tap : taps) sum += tap;
  for (double& tap : taps) tap /= sum;
  return taps;
}

Demodulator::Demodulator(const DemodulationParameters& parameters,
                         const ConverterParameters& converter, double frequency)
    : converter_(converter),
      taps_(demodulationFilter(converter, frequency, parameters.stopband_attenuation)),
      samples_(static_cast<std::size_t>(converter.block_samples)),
      earlier_(taps_.size() > samples_ ? paddedToLanes(taps_.size() - samples_) : 0),
      weights_(earlier_ + paddedToLanes(samples_), 0.0) {
  const std::size_t end = earlier_ + samples_;
  std::copy(taps_.begin(), taps_.end(),
            weights_.begin() + static_cast<std::ptrdiff_t>(end - taps_.size()));
  for (AlignedVector& mixed : mixed_) mixed.assign(weights_.size(), 0.0);
}

double Demodulator::groupDelay() const {
  return (0.5 * static_cast<double>(taps_.size() - 1) + 1.0) * converter_.samplePeriod();
}

void Demodulator::reset() {
  for (AlignedVector& mixed : mixed_) std::fill(mixed.begin(), mixed.end(), 0.0);
}

std::int64_t Demodulator::settlingBlocks() const {
  const auto earlier = static_cast<std::int64_t>(taps_.size()) - converter_.block_samples;
  return earlier <= 0 ? 0 : (earlier + converter_.block_samples - 1) / converter_.block_samples;
}

Envelope Demodulator::process(const DisplacementBlock& block) {
  double sums[4];
  for (std::size_t k = 0; k < 4; ++k) {
    double* const mixed = mixed_[k].data();
    std::copy(mixed + samples_, mixed + samples_ + earlier_, mixed);
  }
  mixDown(block.x.data(), block.y.data(), block.reference_phase,
          block.reference_frequency * converter_.samplePeriod(), samples_,
          weights_.data() + earlier_, samples_ - std::min(samples_, earlier_), &mixed_[0][earlier_],
          &mixed_[1][earlier_], &mixed_[2][earlier_], &mixed_[3][earlier_], sums);
  for (std::size_t k = 0; k < 4; ++k) {
    sums[k] = 2.0 * (sums[k] + weightedSum(weights_.data(), mixed_[k].data(), earlier_));
  }
  return {Complex(sums[0], sums[1]), Complex(sums[2], sums[3])};
}

}  // namespace cvg
