#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <random>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/drive_synthesis.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/loop_status.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// A locked gyroscope simulated with the averaged model: the same data for the identifier as from
/// the time domain, at less cost. The loops are plain PI controllers.
class AveragedLoop {
 public:
  struct Options {
    DeviceKnowledge known = {14e3, 22000.0};
    DeviceParameters device{0.02, 0.03, -30e-6, -40e-6, 1.1e5};
    double block = 1e-3;         // [s]
    double group_delay = 0.0;    // [s]
    double noise_density = 0.0;  // of the displacements, one-sided [V/sqrt(Hz)]
    double virtual_rate = toRadians(12.0);
    double rotation_rate = 0.0;  // [rad/s]
    double theta = 0.1;          // at the start [rad]
    double amplitude = 1.0;      // setpoint of a; 1 V at the start [V]
    DampingCompensation compensation;
    double bandwidth = 20.0;  // of the three loops [Hz]
    unsigned seed = 1;
    std::uint32_t session = 1;
  };

  struct Output {
    OrbitalElements elements;
    ControlGains gains;
  };

  explicit AveragedLoop(const Options& options)
      : options_(options),
        model_(options.known),
        engine_(options.seed),
        whole_delay_(static_cast<int>(std::floor(options.group_delay / options.block + 1e-9))),
        rest_(options.group_delay - whole_delay_ * options.block) {
    if (rest_ < 1e-12) rest_ = 0.0;
    orbit_ = {1.0, 0.0, options.theta, -kPi / 2};
    measured_ = orbit_;
    // In balance from the start, as after a long lock.
    amplitude_integral_ = model_.decayRate();
    valid_.assign(static_cast<std::size_t>(whole_delay_), orbit_);
    command();
    last_drive_ = next_.drive.total();
  }

  /// The true orbit at the end of the last block.
  const Orbit& orbit() const { return orbit_; }
  void setCompensation(const DampingCompensation& gains) { options_.compensation = gains; }
  void setVirtualRate(double rate) { options_.virtual_rate = rate; }       ///< [rad/s]
  void setRotationRate(double rate) { options_.rotation_rate = rate; }     ///< k Om [rad/s]
  void setAmplitude(double amplitude) { options_.amplitude = amplitude; }  ///< setpoint of a [V]

  Output step() {
    // The gains of this block were decided at the end of the last one.
    ControlGains acting = next_;
    acting.stamp = {options_.session, sequence_, end_ns_ + durationNs(), durationNs()};
    AveragedInput input;
    input.drive = acting.drive.total();
    input.reference_frequency = acting.reference_frequency;
    input.rotation_rate = options_.rotation_rate;
    step(last_drive_, input.drive, acting.reference_phase, acting.reference_frequency);
    last_drive_ = input.drive;
    input.pattern_rate = model_.rates(orbit_, options_.device, input).theta;
    orbit_ = model_.integrate(orbit_, options_.device, input, options_.block - rest_, 1);
    valid_.push_back(orbit_);
    if (rest_ > 0.0) orbit_ = model_.integrate(orbit_, options_.device, input, rest_, 1);
    end_ns_ += durationNs();

    Output output;
    output.gains = acting;
    output.elements.stamp = acting.stamp;
    output.elements.group_delay = options_.group_delay;
    output.elements.orbit = noisy(valid_.front());
    valid_.pop_front();
    LoopStatus& status = output.elements.status;
    status.amplitude_locked = status.quadrature_locked = status.phase_locked = true;
    output.gains.status = status;
    measured_ = output.elements.orbit;
    ++sequence_;
    command();
    return output;
  }

 private:
  std::int64_t durationNs() const {
    return static_cast<std::int64_t>(std::llround(1e9 * options_.block));
  }

  /// Jump of the slow envelope where a held drive steps.
  void step(const Eigen::Vector2cd& before, const Eigen::Vector2cd& after, double phase, double w) {
    const Eigen::Vector2cd change = after - before;
    const Eigen::Vector2cd envelope =
        envelopeFromOrbit(orbit_) +
        options_.device.drive_gain / (4.0 * w * w) *
            (change - change.conjugate() * std::polar(1.0, -2.0 * phase));
    const double theta = orbit_.theta;
    orbit_ = orbitFromEnvelope(envelope);
    orbit_.theta = theta + wrapToPi(orbit_.theta - theta);
  }

  Orbit noisy(const Orbit& orbit) {
    if (options_.noise_density == 0.0) return orbit;
    const double sigma = options_.noise_density / std::sqrt(options_.block);
    std::normal_distribution<double> noise(0.0, sigma);
    Eigen::Vector2cd envelope = envelopeFromOrbit(orbit);
    for (int axis = 0; axis < 2; ++axis) {
      const double re = noise(engine_);
      const double im = noise(engine_);
      envelope[axis] += std::complex<double>(re, im);
    }
    Orbit result = orbitFromEnvelope(envelope);
    result.theta = orbit.theta + wrapToPi(result.theta - orbit.theta);
    return result;
  }

  void command() {
    const double wn = kTwoPi * options_.bandwidth;
    const auto loop = [&](double error, double& integral) {
      integral += wn * wn * error * options_.block;
      return 2.0 * wn * error + integral;
    };
    const double w =
        kTwoPi * options_.known.natural_frequency + loop(measured_.phi + kPi / 2, phase_integral_);
    const double force_per_rate = 2.0 * w / options_.device.drive_gain;
    DriveGains gains;
    gains.sustain_force =
        force_per_rate * loop(options_.amplitude - measured_.a, amplitude_integral_);
    gains.alpha = force_per_rate * loop(measured_.b, quadrature_integral_);
    gains.virtual_rate = options_.virtual_rate;
    gains.compensation = options_.compensation;
    Orbit ahead = measured_;
    const double rate = -options_.virtual_rate - options_.rotation_rate;
    ahead.theta += rate * (options_.group_delay + 0.5 * options_.block);
    next_ = ControlGains{};
    next_.reference_phase = wrapToPi(phase_);
    phase_ += w * options_.block;
    next_.reference_frequency = w;
    next_.beta = gains.sustain_force / (w * ahead.a);
    next_.alpha = gains.alpha;
    next_.virtual_rate = gains.virtual_rate;
    next_.compensation = gains.compensation;
    next_.drive = synthesizeDrive(ahead, gains, w, options_.device.drive_gain);
  }

  Options options_;
  AveragedModel model_;
  std::mt19937 engine_;
  double phase_ = 0.0;  // of the NCO at the start of the next block [rad]
  int whole_delay_;
  double rest_;
  Orbit orbit_;
  Orbit measured_;
  std::deque<Orbit> valid_;  // orbits that are still within the group delay
  double amplitude_integral_ = 0.0;
  double quadrature_integral_ = 0.0;
  double phase_integral_ = 0.0;
  ControlGains next_;
  Eigen::Vector2cd last_drive_;
  std::uint64_t sequence_ = 0;
  std::int64_t end_ns_ = 1000000000;
};

}  // namespace cvg
