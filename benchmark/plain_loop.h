#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/drive_synthesis.h"
#include "ring_gyro/control/loop_filter.h"
#include "ring_gyro/demodulation/demodulator.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// The closed loop written in the most direct way: the equations of motion by classical Runge-Kutta
/// with 8 steps per sample (114 per cycle at 14 kHz), std::normal_distribution, std::sin and
/// std::cos for the reference of drive and demodulation, the same low-pass once per block, PI
/// loops.
class PlainLoop {
 public:
  explicit PlainLoop(const LoopConfiguration& configuration)
      : ring_(configuration.plant.resonator),
        converter_(configuration.converter),
        gain_(ring_.driveGain()),
        sigma_(configuration.plant.sense.noise_density * std::sqrt(0.5 * converter_.sample_rate)),
        virtual_rate_(configuration.control.virtual_rate),
        taps_(demodulationFilter(converter_, ring_.natural_frequency,
                                 configuration.demodulation.stopband_attenuation)),
        phase_loop_(loopGains(20.0, 1.0), converter_.blockDuration(), -1e3, 1e3),
        amplitude_loop_(loopGains(20.0, 1.0), converter_.blockDuration(), 0.0, 1e3),
        quadrature_loop_(loopGains(20.0, 1.0), converter_.blockDuration(), -1e3, 1e3),
        frequency_(ring_.angularFrequency()) {
    for (auto& history : mixed_) history.assign(taps_.size(), 0.0);
    state_ = {0.0, 0.0, ring_.angularFrequency(), 0.0};
  }

  /// Runs one block.
  const Orbit& step() {
    constexpr int kSteps = 8;
    const double h = converter_.samplePeriod() / kSteps;
    for (std::int64_t j = 0; j < converter_.block_samples; ++j) {
      const double x = state_[0] + sigma_ * normal_(engine_);
      const double y = state_[1] + sigma_ * normal_(engine_);
      const double cosine = std::cos(phase_);
      const double sine = std::sin(phase_);
      const std::array<double, 4> mixed = {2.0 * x * cosine, -2.0 * x * sine, 2.0 * y * cosine,
                                           -2.0 * y * sine};
      for (std::size_t k = 0; k < 4; ++k) mixed_[k][newest_] = mixed[k];
      newest_ = (newest_ + 1) % taps_.size();
      for (int k = 0; k < kSteps; ++k) {
        rungeKutta(h);
        phase_ += frequency_ * h;
      }
    }
    phase_ = std::fmod(phase_, kTwoPi);
    control();
    return orbit_;
  }

 private:
  using State = std::array<double, 4>;

  State rates(const State& s, double phase) const {
    const double w0 = ring_.angularFrequency();
    const double damping = w0 / ring_.quality_factor;
    const double c = std::cos(phase);
    const double q = std::sin(phase);
    const double fx = drive_.x().real() * c - drive_.x().imag() * q;
    const double fy = drive_.y().real() * c - drive_.y().imag() * q;
    return {s[2], s[3],
            gain_ * fx - damping * ((1.0 + ring_.gamma1) * s[2] + ring_.gamma2 * s[3]) -
                w0 * w0 * ((1.0 + ring_.mu1) * s[0] + ring_.mu2 * s[1]),
            gain_ * fy - damping * (ring_.gamma2 * s[2] + (1.0 - ring_.gamma1) * s[3]) -
                w0 * w0 * (ring_.mu2 * s[0] + (1.0 - ring_.mu1) * s[1])};
  }

  void rungeKutta(double h) {
    const auto moved = [this](const State& rate, double time) {
      State s;
      for (std::size_t k = 0; k < 4; ++k) s[k] = state_[k] + time * rate[k];
      return s;
    };
    const State k1 = rates(state_, phase_);
    const State k2 = rates(moved(k1, 0.5 * h), phase_ + 0.5 * frequency_ * h);
    const State k3 = rates(moved(k2, 0.5 * h), phase_ + 0.5 * frequency_ * h);
    const State k4 = rates(moved(k3, h), phase_ + frequency_ * h);
    for (std::size_t k = 0; k < 4; ++k) {
      state_[k] += h / 6.0 * (k1[k] + 2.0 * (k2[k] + k3[k]) + k4[k]);
    }
  }

  void control() {
    std::array<double, 4> filtered = {};
    for (std::size_t n = 0; n < taps_.size(); ++n) {
      const std::size_t at = (newest_ + n) % taps_.size();
      for (std::size_t k = 0; k < 4; ++k) filtered[k] += taps_[n] * mixed_[k][at];
    }
    using Complex = std::complex<double>;
    orbit_ = orbitFromEnvelope(
        Eigen::Vector2cd(Complex(filtered[0], filtered[1]), Complex(filtered[2], filtered[3])));
    frequency_ = ring_.angularFrequency() + phase_loop_.update(orbit_.phi + 0.5 * kPi);
    const double force_per_rate = 2.0 * frequency_ / gain_;
    DriveGains gains;
    gains.sustain_force = force_per_rate * amplitude_loop_.update(1.0 - orbit_.a);
    gains.alpha = force_per_rate * quadrature_loop_.update(orbit_.b) / orbit_.a;
    gains.virtual_rate = virtual_rate_;
    drive_ = synthesizeDrive(orbit_, gains, frequency_, gain_).total();
  }

  ResonatorParameters ring_;
  ConverterParameters converter_;
  double gain_;
  double sigma_;
  double virtual_rate_;
  std::vector<double> taps_;
  LoopFilter phase_loop_;
  LoopFilter amplitude_loop_;
  LoopFilter quadrature_loop_;
  double frequency_;
  double phase_ = 0.0;
  State state_;
  Eigen::Vector2cd drive_ = Eigen::Vector2cd::Zero();
  std::array<std::vector<double>, 4> mixed_;
  std::size_t newest_ = 0;
  Orbit orbit_;
  std::mt19937_64 engine_{1};
  std::normal_distribution<double> normal_;
};

}  // namespace cvg
