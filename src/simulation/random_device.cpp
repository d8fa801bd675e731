#include "ring_gyro/simulation/random_device.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

constexpr double kDriveRange = 10.0;       // [V]
constexpr double kLowestBandwidth = 20.0;  // [Hz]
constexpr double kWidestBandwidth = 60.0;  // limit due to the delay of 1 ms blocks [Hz]
// Largest lag in b / a and in phi [rad] at which the loops stay locked.
constexpr double kLag = 3e-3;

/// Own distributions, because those of the standard library differ between libraries.
class Draw {
 public:
  explicit Draw(std::uint64_t index) : engine_(index) {}

  double uniform(double lowest, double highest) {
    return lowest + (highest - lowest) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
  }
  double logUniform(double lowest, double highest) {
    return lowest * std::exp(uniform(0.0, std::log(highest / lowest)));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace

LoopConfiguration randomDevice(const LoopConfiguration& base, std::uint64_t index) {
  Draw draw(index);
  LoopConfiguration result = base;
  ResonatorParameters& ring = result.plant.resonator;
  ring.natural_frequency = draw.logUniform(3e3, 100e3);
  ring.quality_factor = draw.logUniform(5e3, 1e6);
  const double gamma = draw.uniform(0.0, 0.1);
  const double gamma_direction = draw.uniform(-kPi, kPi);
  const double mu = draw.uniform(0.0, 1e-4);
  const double mu_direction = draw.uniform(-kPi, kPi);
  const double share_of_range = draw.logUniform(0.1, 1.0 / 3.0);
  const double known_gain = draw.uniform(0.95, 1.05);
  const double sense = draw.uniform(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
  ring.gamma1 = gamma * std::cos(gamma_direction);
  ring.gamma2 = gamma * std::sin(gamma_direction);
  ring.mu1 = mu * std::cos(mu_direction);
  ring.mu2 = mu * std::sin(mu_direction);

  const double decay = ring.decayRate();
  const double w0 = ring.angularFrequency();
  const double observed = std::max(10.0 / decay, 20.0);  // [s]
  const double rate = std::max(3.5 * decay * gamma, kTwoPi / observed);
  const double bandwidth = std::max(kLowestBandwidth, std::sqrt(w0 * mu * rate / kLag) / kTwoPi);
  if (bandwidth > kWidestBandwidth) {
    throw std::invalid_argument(
        "random device: at the rate that its damping mismatch asks for, its stiffness mismatch "
        "swings faster than loops of " +
        std::to_string(static_cast<int>(kWidestBandwidth)) + " Hz follow");
  }

  // Sustain 2 xi0 w0 w a / ks; the others relative to it.
  const double relative = 1.0 + gamma + ring.quality_factor * mu + rate / decay;
  const double sustain = share_of_range * kDriveRange / relative;
  ring.drive_gain = 2.0 * decay * w0 * base.control.amplitude / sustain;

  result.converter.block_samples =
      static_cast<std::int64_t>(std::ceil(10.0 * ring.natural_frequency / 1e3));
  result.converter.sample_rate = 1e3 * static_cast<double>(result.converter.block_samples);
  result.device.natural_frequency = ring.natural_frequency;
  result.device.quality_factor = ring.quality_factor;
  result.device.drive_gain = known_gain * ring.drive_gain;
  result.device.angular_gain = ring.angular_gain;
  result.control.drive_limit = kDriveRange;
  result.control.virtual_rate = sense * rate;
  for (LoopTuning* tuning : {&result.control.phase_loop, &result.control.quadrature_loop,
                             &result.control.amplitude_loop, &result.control.angle_tracker}) {
    tuning->bandwidth = bandwidth;
  }
  // Ring-up with the whole range, lock, then the observed time.
  result.run.duration = std::ceil(2.0 + 1.0 / decay + observed);
  return result;
}

}  // namespace cvg
