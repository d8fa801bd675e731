#include "ring_gyro/control/control_loops.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/vector_kernels.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/signals/calibration_command.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

constexpr double kLockTime = 0.05;  // [s]
constexpr double kPhaseLockError = toRadians(0.5);
constexpr double kAmplitudeLockError = 0.01;   // of the setpoint
constexpr double kQuadratureLockError = 0.01;  // of a
constexpr double kOrbitFound = 0.05;           // of the setpoint: enough to close the loops
constexpr double kOrbitLost = 0.02;            // of the setpoint: too small to control

LoopGains gainsOf(const LoopTuning& tuning, double decay = 0.0) {
  return loopGains(tuning.bandwidth, tuning.damping, decay);
}

std::int64_t lockBlocks(const ConverterParameters& converter) {
  return static_cast<std::int64_t>(std::ceil(kLockTime / converter.blockDuration()));
}

const ControlParameters& checkedControl(const ControlParameters& p) {
  if (p.compensation && p.calibration_run) {
    throw std::invalid_argument(
        "control: compensation and calibration_run cannot both be true, each sets the damping "
        "compensation");
  }
  return checked(p, "control");
}

/// Effect of the largest drive on the orbit at unit amplitude [V/s].
double mostRate(const DeviceKnowledge& device, const ControlParameters& control) {
  return control.drive_limit * device.drive_gain / (2.0 * device.angularFrequency());
}

}  // namespace

ControlLoops::ControlLoops(const DeviceKnowledge& device, const ControlParameters& control,
                           const DemodulationParameters& demodulation,
                           const ConverterParameters& converter, const Corrections& corrections)
    : device_(checked(device, "device")),
      parameters_(checkedControl(control)),
      demodulation_(checked(demodulation, "demodulation")),
      converter_(checked(converter, "converter")),
      corrections_(checked(corrections, "calibration")),
      demodulator_(demodulation, converter, device.natural_frequency),
      phase_loop_(gainsOf(control.phase_loop), converter.blockDuration(),
                  -kTwoPi * control.frequency_range, kTwoPi * control.frequency_range),
      amplitude_loop_(gainsOf(control.amplitude_loop, device.decayRate()),
                      converter.blockDuration(), 0.0, mostRate(device, control)),
      quadrature_loop_(gainsOf(control.quadrature_loop), converter.blockDuration(),
                       -mostRate(device, control), mostRate(device, control)),
      frequency_feedforward_(control.learning_rate, converter.blockDuration()),
      quadrature_feedforward_(control.learning_rate, converter.blockDuration()),
      angle_tracker_gains_(gainsOf(control.angle_tracker)),
      amplitude_lock_(lockBlocks(converter)),
      quadrature_lock_(lockBlocks(converter)),
      phase_lock_(lockBlocks(converter)),
      lead_(demodulator_.groupDelay() + 0.5 * converter.blockDuration()),
      frequency_(kTwoPi * (device.natural_frequency + control.frequency_offset)) {
  LoopSettings settings;
  settings.virtual_rate = control.virtual_rate;
  settings.amplitude_modulation = control.amplitude_modulation;
  settings.amplitude_modulation_frequency = control.amplitude_modulation_frequency;
  settings.corrections = corrections;
  setSettings(settings);
}

void ControlLoops::restart() {
  *this = ControlLoops(device_, parameters_, demodulation_, converter_, corrections_);
}

void ControlLoops::setSettings(const LoopSettings& settings) {
  settings_ = settings;
  drive_correction_ = settings.corrections.driveCorrection();
  compensation_ = {};
  if (settings.corrections.cancel_damping) {
    const double per_gamma = 2.0 * device_.decayRate() / device_.drive_gain;  // [s]
    compensation_ = {per_gamma * settings.corrections.gamma1,
                     per_gamma * settings.corrections.gamma2};
  }
}

double ControlLoops::amplitudeSetpoint() const {
  if (settings_.amplitude_modulation == 0.0) return parameters_.amplitude;
  const double time = static_cast<double>(last_stamp_.sequence) * converter_.blockDuration();
  const double swing = std::sin(kTwoPi * settings_.amplitude_modulation_frequency * time);
  return parameters_.amplitude * (1.0 + settings_.amplitude_modulation * swing);
}

bool ControlLoops::samplesUsable(const DisplacementBlock& block) const {
  const auto samples = static_cast<std::size_t>(converter_.block_samples);
  if (block.x.size() != samples || block.y.size() != samples) return false;
  const Eigen::Map<const Eigen::ArrayXd> x(block.x.data(), converter_.block_samples);
  const Eigen::Map<const Eigen::ArrayXd> y(block.y.data(), converter_.block_samples);
  // A finite sum has finite terms; the slow check is for sums that overflow.
  return std::isfinite(sumOf(x.data(), samples) + sumOf(y.data(), samples)) ||
         (x.allFinite() && y.allFinite());
}

const LoopOutput& ControlLoops::process(const DisplacementBlock& block) {
  if (started_ && block.stamp.session != last_stamp_.session) restart();
  LoopStatus& status = output_.elements.status;
  Reference reference{block.reference_phase, block.reference_frequency};
  const bool referenced = std::isfinite(reference.phase) && std::isfinite(reference.frequency);
  // Before the first block of a session the ring was at rest, which is what an empty filter means.
  const std::uint64_t expected = started_ ? last_stamp_.sequence + 1 : 0;
  if (!referenced) {
    const std::uint64_t missed =
        block.stamp.sequence > expected ? block.stamp.sequence - expected : 0;
    reference = runOn(missed, block.stamp.duration());
  }
  const bool usable = referenced && samplesUsable(block);
  if (!usable || block.stamp.sequence != expected) {
    demodulator_.reset();
    blocks_to_settle_ = demodulator_.settlingBlocks();
  }
  started_ = true;
  last_stamp_ = block.stamp;
  // The filter's output is an envelope only when its window contains nothing but good samples.
  status.invalid_samples = !usable || blocks_to_settle_ > 0;
  status.converter_saturated = block.saturated_samples > 0;
  if (usable) {
    const Envelope envelope = settings_.corrections.undistorted(demodulator_.process(block));
    if (blocks_to_settle_ > 0) {
      --blocks_to_settle_;
    } else {
      measure(envelope, block.stamp.duration());
    }
  }
  output_.elements.stamp = block.stamp;
  output_.elements.group_delay = demodulator_.groupDelay();
  output_.elements.theta_rate = theta_rate_;
  const double theta = output_.elements.orbit.theta;
  output_.elements.angle = settings_.corrections.outputAngle(theta);
  output_.elements.angle_rate = theta_rate_ * settings_.corrections.outputSlope(theta);
  recallActedDrive(block, reference);
  status.drive_saturated = output_.gains.status.drive_saturated || block.clipped_drive_samples > 0;
  status.amplitude_locked = amplitude_lock_.locked();
  status.quadrature_locked = quadrature_lock_.locked();
  status.phase_locked = phase_lock_.locked();
  output_.gains.status = status;
  command(block, reference);
  return output_;
}

/// The reference of the last command, continued by this number of blocks.
ControlLoops::Reference ControlLoops::runOn(std::uint64_t blocks, double period) const {
  const DriveCommand& last = output_.command;
  const double turned = last.reference_frequency * static_cast<double>(blocks) * period;
  return {wrapToPi(last.reference_phase + turned), last.reference_frequency};
}

void ControlLoops::measure(const Envelope& envelope, double period) {
  Orbit orbit = orbitFromEnvelope(envelope);
  orbit.theta = unwrapper_.unwrap(orbit.theta);
  output_.elements.orbit = orbit;

  const double found = orbit_found_ ? kOrbitLost : kOrbitFound;
  const bool had_orbit = orbit_found_;
  orbit_found_ = orbit.a > found * parameters_.amplitude;
  if (orbit_found_ && !had_orbit) {
    tracked_theta_ = orbit.theta;
    theta_rate_ = 0.0;
  }
  if (orbit_found_) {
    const double error = orbit.theta - (tracked_theta_ + theta_rate_ * period);
    tracked_theta_ += (theta_rate_ + angle_tracker_gains_.proportional * error) * period;
    theta_rate_ += angle_tracker_gains_.integral * error * period;
  }
  amplitude_lock_.update(std::abs(orbit.a / amplitudeSetpoint() - 1.0) < kAmplitudeLockError);
  quadrature_lock_.update(orbit_found_ && std::abs(orbit.b) < kQuadratureLockError * orbit.a);
  phase_lock_.update(orbit_found_ && std::abs(orbit.phi + 0.5 * kPi) < kPhaseLockError);
}

void ControlLoops::recallActedDrive(const DisplacementBlock& block, const Reference& reference) {
  output_.gains = ControlGains{};
  if (block.driven) {
    const ActedDrive& acted = drives_[block.drive_answers_sequence % kDriveMemory];
    if (acted.known && acted.answers_sequence == block.drive_answers_sequence) {
      output_.gains = acted.gains;
      output_.gains.status.drive_saturated = acted.saturated;
    } else {
      // The plant continued with a drive that is no longer known, so the loops must not learn now.
      output_.gains.status.drive_saturated = true;
    }
  }
  output_.gains.stamp = block.stamp;
  output_.gains.reference_frequency = reference.frequency;
  output_.gains.reference_phase = reference.phase;
}

DriveGains ControlLoops::closeLoops(double theta) {
  const Orbit& orbit = output_.elements.orbit;
  const bool locked = amplitude_lock_.locked() && quadrature_lock_.locked() && phase_lock_.locked();
  const double force_per_rate = 2.0 * frequency_ / device_.drive_gain;  // [V / (V/s)]
  const double learnt_frequency = frequency_feedforward_.at(theta);
  const double frequency_correction = phase_loop_.update(orbit.phi + 0.5 * kPi, learnt_frequency);
  frequency_ = kTwoPi * (device_.natural_frequency + parameters_.frequency_offset) +
               frequency_correction + learnt_frequency;
  DriveGains gains;
  gains.sustain_force = force_per_rate * amplitude_loop_.update(amplitudeSetpoint() - orbit.a);
  // b' = -ks a alpha / (2 w): alpha grows with b.
  const double quadrature_correction = quadrature_loop_.update(orbit.b);
  gains.alpha =
      force_per_rate * (quadrature_correction + quadrature_feedforward_.at(theta)) / orbit.a;
  if (locked && !was_locked_) {
    // The loop's integral is mostly an offset of the NCO, not a swing with the angle. The values
    // learnt before the loss of lock stay.
    frequency_feedforward_.addConstant(phase_loop_.integral());
    phase_loop_.reset();
  } else if (locked) {
    frequency_feedforward_.learn(frequency_correction, theta);
    quadrature_feedforward_.learn(quadrature_correction, theta);
  }
  was_locked_ = locked;
  if (locked) {
    gains.virtual_rate = settings_.virtual_rate + settings_.corrections.driftAt(theta);
    gains.compensation = compensation_;
  }
  return gains;
}

void ControlLoops::command(const DisplacementBlock& block, const Reference& reference) {
  ActedDrive& next = drives_[block.stamp.sequence % kDriveMemory];
  const double period = block.stamp.duration();
  DriveCommand& command = output_.command;
  ControlGains gains;
  bool saturated = false;

  if (output_.elements.status.invalid_samples) {
    gains = output_.gains;  // coast with the last gains
    saturated = gains.status.drive_saturated;
  } else if (orbit_found_) {
    Orbit ahead = output_.elements.orbit;
    ahead.theta += theta_rate_ * lead_;
    const DriveGains wanted = closeLoops(ahead.theta);
    gains.drive = synthesizeDrive(ahead, wanted, frequency_, device_.drive_gain);
    gains.beta = wanted.sustain_force / (frequency_ * ahead.a);
    gains.alpha = wanted.alpha;
    gains.virtual_rate = wanted.virtual_rate;
    gains.compensation = wanted.compensation;
  } else {
    // No orbit to control yet: ring up along x, in phase with the velocity of phi = -pi/2.
    phase_loop_.reset();
    amplitude_loop_.reset();
    quadrature_loop_.reset();
    frequency_feedforward_.reset();
    quadrature_feedforward_.reset();
    frequency_ = kTwoPi * (device_.natural_frequency + parameters_.frequency_offset);
    gains.drive.sustain = {parameters_.drive_limit, 0.0};
  }

  Envelope sent = sentFor(gains.drive.total());
  const double largest = sent.cwiseAbs().maxCoeff();
  if (largest > parameters_.drive_limit) {
    const double scale = parameters_.drive_limit / largest;
    gains.drive.sustain *= scale;
    gains.drive.quadrature *= scale;
    gains.drive.steering *= scale;
    gains.drive.compensation *= scale;
    sent *= scale;
    saturated = true;
  }

  next.answers_sequence = block.stamp.sequence;
  next.known = true;
  next.saturated = saturated;
  next.gains = gains;

  command.answers_sequence = block.stamp.sequence;
  command.reference_phase = wrapToPi(reference.phase + reference.frequency * period);
  command.reference_frequency = frequency_;
  command.envelope = sent;
  command.table_rate = settings_.table_rate;
  command.end_of_run = settings_.end_of_run;
}

/// The drive to send so that `total` acts on the ring: multiplied by the inverse of the drive's
/// path, with the delay and gain of its hold compensated.
Envelope ControlLoops::sentFor(const Envelope& total) const {
  return (std::polar(1.0, frequency_ * parameters_.hold_delay) / parameters_.hold_gain) *
         (drive_correction_ * total);
}

}  // namespace cvg
