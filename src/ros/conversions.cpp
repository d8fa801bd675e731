#include "ring_gyro/ros/conversions.h"

#include <algorithm>
#include <cmath>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/compensation_decision.h"

namespace ring_gyro::bridge {
namespace {

/// The fields that all messages of a block share: end of the block, session, sequence, duration.
template <typename Message>
void stampToMessage(const cvg::BlockStamp& stamp, Message& message) {
  message.header.stamp = timeFromNanoseconds(stamp.end_ns);
  message.session = stamp.session;
  message.sequence = stamp.sequence;
  message.duration = static_cast<std::uint64_t>(stamp.duration_ns);
}

template <typename Message>
cvg::BlockStamp stampFromMessage(const Message& message) {
  return {message.session, message.sequence, nanosecondsFromTime(message.header.stamp),
          static_cast<std::int64_t>(message.duration)};
}

void envelopeToMessage(const cvg::Envelope& envelope, ring_gyro::Envelope& message) {
  message.x_real = envelope[0].real();
  message.x_imag = envelope[0].imag();
  message.y_real = envelope[1].real();
  message.y_imag = envelope[1].imag();
}

cvg::Envelope envelopeFromMessage(const ring_gyro::Envelope& message) {
  return {std::complex<double>(message.x_real, message.x_imag),
          std::complex<double>(message.y_real, message.y_imag)};
}

using Places = ring_gyro::ParameterEstimate;
static_assert(int{Places::A} == cvg::kA && int{Places::B} == cvg::kB &&
                  int{Places::GAMMA1} == cvg::kGamma1 && int{Places::GAMMA2} == cvg::kGamma2 &&
                  int{Places::MU1} == cvg::kMu1 && int{Places::MU2} == cvg::kMu2 &&
                  int{Places::DRIVE_GAIN} == cvg::kDriveGain,
              "an estimate travels in the order of the states");

bool isZero(const cvg::Envelope& envelope) { return envelope[0] == 0.0 && envelope[1] == 0.0; }

/// A log may contain the whole drive but not its parts: then the whole is stored as one part.
cvg::DriveContributions driveFromMessage(const ring_gyro::ControlGains& message) {
  cvg::DriveContributions drive;
  drive.sustain = envelopeFromMessage(message.sustain);
  drive.quadrature = envelopeFromMessage(message.quadrature);
  drive.steering = envelopeFromMessage(message.steering);
  drive.compensation = envelopeFromMessage(message.compensation);
  if (isZero(drive.sustain) && isZero(drive.quadrature) && isZero(drive.steering) &&
      isZero(drive.compensation)) {
    const cvg::Envelope total = envelopeFromMessage(message.drive);
    if (!isZero(total)) drive.sustain = total;
  }
  return drive;
}

void statusToMessage(const cvg::LoopStatus& status, ring_gyro::LoopStatus& message) {
  message.amplitude_locked = status.amplitude_locked;
  message.quadrature_locked = status.quadrature_locked;
  message.phase_locked = status.phase_locked;
  message.invalid_samples = status.invalid_samples;
  message.converter_saturated = status.converter_saturated;
  message.drive_saturated = status.drive_saturated;
}

cvg::LoopStatus statusFromMessage(const ring_gyro::LoopStatus& message) {
  cvg::LoopStatus status;
  status.amplitude_locked = message.amplitude_locked != 0;
  status.quadrature_locked = message.quadrature_locked != 0;
  status.phase_locked = message.phase_locked != 0;
  status.invalid_samples = message.invalid_samples != 0;
  status.converter_saturated = message.converter_saturated != 0;
  status.drive_saturated = message.drive_saturated != 0;
  return status;
}

void harmonicsToMessage(const cvg::AngleHarmonics& function, double& constant,
                        std::vector<double>& cosine, std::vector<double>& sine) {
  constant = function.constant;
  cosine = function.cosine;
  sine = function.sine;
}

void correctionsToMessage(const cvg::Corrections& corrections, ring_gyro::Calibration& message) {
  message.correct_pickoff = corrections.correct_pickoff;
  message.correct_phase = corrections.correct_phase;
  message.correct_drive_gains = corrections.correct_drive_gains;
  message.correct_phase_mismatch = corrections.correct_phase_mismatch;
  message.cancel_damping = corrections.cancel_damping;
  message.cancel_drift = corrections.cancel_drift;
  message.map_angle = corrections.map_angle;
  message.pickoff_cubic = corrections.pickoff_cubic;
  message.drive_phase = corrections.drive_path.phase;
  message.drive_mismatch = corrections.drive_path.mismatch;
  message.drive_skew = corrections.drive_path.skew;
  message.drive_rotation = corrections.drive_path.rotation;
  message.phase_mismatch = corrections.drive_path.phase_mismatch;
  message.phase_skew = corrections.drive_path.phase_skew;
  message.rotation_phase = corrections.drive_path.rotation_phase;
  message.gamma1 = corrections.gamma1;
  message.gamma2 = corrections.gamma2;
  harmonicsToMessage(corrections.drift, message.drift_constant, message.drift_cosine,
                     message.drift_sine);
  harmonicsToMessage(corrections.angle_map, message.angle_map_constant, message.angle_map_cosine,
                     message.angle_map_sine);
}

cvg::Corrections correctionsFromMessage(const ring_gyro::Calibration& message) {
  cvg::Corrections corrections;
  corrections.correct_pickoff = message.correct_pickoff != 0;
  corrections.correct_phase = message.correct_phase != 0;
  corrections.correct_drive_gains = message.correct_drive_gains != 0;
  corrections.correct_phase_mismatch = message.correct_phase_mismatch != 0;
  corrections.cancel_damping = message.cancel_damping != 0;
  corrections.cancel_drift = message.cancel_drift != 0;
  corrections.map_angle = message.map_angle != 0;
  corrections.pickoff_cubic = message.pickoff_cubic;
  corrections.drive_path.phase = message.drive_phase;
  corrections.drive_path.mismatch = message.drive_mismatch;
  corrections.drive_path.skew = message.drive_skew;
  corrections.drive_path.rotation = message.drive_rotation;
  corrections.drive_path.phase_mismatch = message.phase_mismatch;
  corrections.drive_path.phase_skew = message.phase_skew;
  corrections.drive_path.rotation_phase = message.rotation_phase;
  corrections.gamma1 = message.gamma1;
  corrections.gamma2 = message.gamma2;
  corrections.drift = {message.drift_constant, message.drift_cosine, message.drift_sine};
  corrections.angle_map = {message.angle_map_constant, message.angle_map_cosine,
                           message.angle_map_sine};
  return corrections;
}

}  // namespace

ros::Time timeFromNanoseconds(std::int64_t nanoseconds) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(nanoseconds));
}

std::int64_t nanosecondsFromTime(const ros::Time& time) {
  return static_cast<std::int64_t>(time.toNSec());
}

void toMessage(const cvg::DisplacementBlock& block, ring_gyro::DisplacementBlock& message) {
  stampToMessage(block.stamp, message);
  message.driven = block.driven;
  message.drive_answers_sequence = block.drive_answers_sequence;
  message.reference_phase = block.reference_phase;
  message.reference_frequency = block.reference_frequency;
  message.saturated_samples = block.saturated_samples;
  message.clipped_drive_samples = block.clipped_drive_samples;
  message.x.assign(block.x.begin(), block.x.end());
  message.y.assign(block.y.begin(), block.y.end());
}

void fromMessage(const ring_gyro::DisplacementBlock& message, cvg::DisplacementBlock& block) {
  block.stamp = stampFromMessage(message);
  block.driven = message.driven != 0;
  block.drive_answers_sequence = message.drive_answers_sequence;
  block.reference_phase = message.reference_phase;
  block.reference_frequency = message.reference_frequency;
  block.saturated_samples = message.saturated_samples;
  block.clipped_drive_samples = message.clipped_drive_samples;
  block.x.assign(message.x.begin(), message.x.end());
  block.y.assign(message.y.begin(), message.y.end());
}

void toMessage(const cvg::DriveCommand& command, const cvg::BlockStamp& answered,
               ring_gyro::DriveCommand& message) {
  message.header.stamp = timeFromNanoseconds(answered.end_ns);
  message.session = answered.session;
  message.answers_sequence = command.answers_sequence;
  message.reference_phase = command.reference_phase;
  message.reference_frequency = command.reference_frequency;
  envelopeToMessage(command.envelope, message.envelope);
  message.table_rate = command.table_rate;
  message.end_of_run = command.end_of_run;
}

void fromMessage(const ring_gyro::DriveCommand& message, cvg::DriveCommand& command) {
  command.answers_sequence = message.answers_sequence;
  command.reference_phase = message.reference_phase;
  command.reference_frequency = message.reference_frequency;
  command.envelope = envelopeFromMessage(message.envelope);
  command.table_rate = message.table_rate;
  command.end_of_run = message.end_of_run != 0;
}

void toMessage(const cvg::OrbitalElements& elements, ring_gyro::OrbitalElements& message) {
  stampToMessage(elements.stamp, message);
  message.group_delay = elements.group_delay;
  message.a = elements.orbit.a;
  message.b = elements.orbit.b;
  message.theta = elements.orbit.theta;
  message.phi = elements.orbit.phi;
  message.theta_rate = elements.theta_rate;
  message.angle = elements.angle;
  message.angle_rate = elements.angle_rate;
  message.turns = static_cast<std::int32_t>(std::trunc(elements.orbit.theta / cvg::kTwoPi));
  statusToMessage(elements.status, message.status);
}

void fromMessage(const ring_gyro::OrbitalElements& message, cvg::OrbitalElements& elements) {
  elements.stamp = stampFromMessage(message);
  elements.group_delay = message.group_delay;
  elements.orbit = {message.a, message.b, message.theta, message.phi};
  elements.theta_rate = message.theta_rate;
  elements.angle = message.angle;
  elements.angle_rate = message.angle_rate;
  elements.status = statusFromMessage(message.status);
}

void toMessage(const cvg::ControlGains& gains, ring_gyro::ControlGains& message) {
  stampToMessage(gains.stamp, message);
  message.reference_frequency = gains.reference_frequency;
  message.reference_phase = gains.reference_phase;
  message.beta = gains.beta;
  message.alpha = gains.alpha;
  message.virtual_rate = gains.virtual_rate;
  message.compensation_gain1 = gains.compensation.gain1;
  message.compensation_gain2 = gains.compensation.gain2;
  envelopeToMessage(gains.drive.total(), message.drive);
  envelopeToMessage(gains.drive.sustain, message.sustain);
  envelopeToMessage(gains.drive.quadrature, message.quadrature);
  envelopeToMessage(gains.drive.steering, message.steering);
  envelopeToMessage(gains.drive.compensation, message.compensation);
  statusToMessage(gains.status, message.status);
}

void fromMessage(const ring_gyro::ControlGains& message, cvg::ControlGains& gains) {
  gains.stamp = stampFromMessage(message);
  gains.reference_frequency = message.reference_frequency;
  gains.reference_phase = message.reference_phase;
  gains.beta = message.beta;
  gains.alpha = message.alpha;
  gains.virtual_rate = message.virtual_rate;
  gains.compensation = {message.compensation_gain1, message.compensation_gain2};
  gains.drive = driveFromMessage(message);
  gains.status = statusFromMessage(message.status);
}

void toMessage(const cvg::ParameterEstimate& estimate, ring_gyro::ParameterEstimate& message) {
  const cvg::StateMatrix covariance = estimate.covariance.matrix();
  message.header.stamp = timeFromNanoseconds(estimate.stamp.end_ns);
  message.session = estimate.stamp.session;
  message.first_sequence = estimate.first_sequence;
  message.last_sequence = estimate.stamp.sequence;
  message.duration = static_cast<std::uint64_t>(estimate.stamp.duration_ns);
  message.used_blocks = estimate.used_blocks;
  message.rejected_blocks = estimate.rejected_blocks;
  message.lost_blocks = estimate.lost_blocks;
  message.updated = estimate.updated;
  for (int i = 0; i < 7; ++i) {
    message.value[i] = estimate.value[i];
    message.sigma[i] = std::sqrt(covariance(i, i));
    for (int j = 0; j < 7; ++j) message.covariance[7 * i + j] = covariance(i, j);
  }
  for (int i = 0; i < 2; ++i) {
    message.innovation[i] = estimate.innovation[i];
    for (int j = 0; j < 2; ++j) {
      message.innovation_covariance[2 * i + j] = estimate.innovation_covariance(i, j);
    }
  }
  message.normalised_innovation_squared = estimate.normalised_innovation_squared;
  message.residual_gamma1 = estimate.residual_gamma1;
  message.residual_gamma2 = estimate.residual_gamma2;
  message.angle_covered = estimate.angle_covered;
  message.converged = estimate.converged;
}

void fromMessage(const ring_gyro::ParameterEstimate& message, cvg::ParameterEstimate& estimate) {
  estimate.stamp = {message.session, message.last_sequence,
                    nanosecondsFromTime(message.header.stamp),
                    static_cast<std::int64_t>(message.duration)};
  estimate.first_sequence = message.first_sequence;
  estimate.used_blocks = message.used_blocks;
  estimate.rejected_blocks = message.rejected_blocks;
  estimate.lost_blocks = message.lost_blocks;
  estimate.updated = message.updated != 0;
  for (int i = 0; i < 7; ++i) estimate.value[i] = message.value[i];
  for (int i = 0; i < 5; ++i) {
    const int state = cvg::kGamma1 + i;
    estimate.parameter_variance[i] = message.covariance[8 * state];
  }
  estimate.covariance.set(
      Eigen::Map<const Eigen::Matrix<double, 7, 7, Eigen::RowMajor>>(message.covariance.data()));
  for (int i = 0; i < 2; ++i) {
    estimate.innovation[i] = message.innovation[i];
    for (int j = 0; j < 2; ++j) {
      estimate.innovation_covariance(i, j) = message.innovation_covariance[2 * i + j];
    }
  }
  estimate.normalised_innovation_squared = message.normalised_innovation_squared;
  estimate.residual_gamma1 = message.residual_gamma1;
  estimate.residual_gamma2 = message.residual_gamma2;
  estimate.angle_covered = message.angle_covered;
  estimate.converged = message.converged != 0;
}

void toMessage(const cvg::CompensationDecision& decision, const ros::Time& data_stamp,
               ring_gyro::CompensationGains& message) {
  message.header.stamp = data_stamp;
  message.session = decision.session;
  message.effective_sequence = decision.effective_sequence;
  message.data_sequence = decision.data_sequence;
  message.gain1 = decision.gains.gain1;
  message.gain2 = decision.gains.gain2;
  message.gamma1 = decision.gamma1;
  message.gamma2 = decision.gamma2;
  message.state = static_cast<std::uint8_t>(decision.state);
}

void fromMessage(const ring_gyro::CompensationGains& message, cvg::CompensationDecision& decision) {
  decision.session = message.session;
  decision.effective_sequence = message.effective_sequence;
  decision.data_sequence = message.data_sequence;
  decision.gains = {message.gain1, message.gain2};
  decision.gamma1 = message.gamma1;
  decision.gamma2 = message.gamma2;
  decision.state = static_cast<cvg::InjectorState>(message.state);
}

void toMessage(const cvg::CalibrationCommand& command, const cvg::BlockStamp& data,
               ring_gyro::CalibrationCommand& message) {
  message.header.stamp = timeFromNanoseconds(data.end_ns);
  message.session = command.session;
  message.effective_sequence = command.effective_sequence;
  message.data_sequence = data.sequence;
  message.virtual_rate = command.settings.virtual_rate;
  message.table_rate = command.settings.table_rate;
  message.amplitude_modulation = command.settings.amplitude_modulation;
  message.amplitude_modulation_frequency = command.settings.amplitude_modulation_frequency;
  message.end_of_run = command.settings.end_of_run;
  correctionsToMessage(command.settings.corrections, message.calibration);
  message.leg = command.leg;
  message.time_left = command.time_left;
  message.finished = command.finished;
  message.failure = command.failure;
}

void fromMessage(const ring_gyro::CalibrationCommand& message, cvg::CalibrationCommand& command) {
  command.session = message.session;
  command.effective_sequence = message.effective_sequence;
  command.settings.virtual_rate = message.virtual_rate;
  command.settings.table_rate = message.table_rate;
  command.settings.amplitude_modulation = message.amplitude_modulation;
  command.settings.amplitude_modulation_frequency = message.amplitude_modulation_frequency;
  command.settings.end_of_run = message.end_of_run != 0;
  command.settings.corrections = correctionsFromMessage(message.calibration);
  command.leg = message.leg;
  command.time_left = message.time_left;
  command.finished = message.finished != 0;
  command.failure = message.failure;
}

void toMessage(const cvg::PlantTruth& truth, ring_gyro::PlantTruth& message) {
  stampToMessage(truth.stamp, message);
  envelopeToMessage(truth.envelope, message.envelope);
  const cvg::Orbit orbit = cvg::orbitFromEnvelope(truth.envelope);
  message.a = orbit.a;
  message.b = orbit.b;
  message.theta = orbit.theta;
  message.phi = orbit.phi;
  message.rotation_rate = truth.rotation_rate;
  message.rotation_angle = truth.rotation_angle;
  message.natural_frequency = truth.natural_frequency;
  message.quality_factor = truth.quality_factor;
  message.gamma1 = truth.gamma1;
  message.gamma2 = truth.gamma2;
  message.mu1 = truth.mu1;
  message.mu2 = truth.mu2;
  message.drive_gain = truth.drive_gain;
}

void fromMessage(const ring_gyro::PlantTruth& message, cvg::PlantTruth& truth) {
  truth.stamp = stampFromMessage(message);
  truth.envelope = envelopeFromMessage(message.envelope);
  truth.rotation_rate = message.rotation_rate;
  truth.rotation_angle = message.rotation_angle;
  truth.natural_frequency = message.natural_frequency;
  truth.quality_factor = message.quality_factor;
  truth.gamma1 = message.gamma1;
  truth.gamma2 = message.gamma2;
  truth.mu1 = message.mu1;
  truth.mu2 = message.mu2;
  truth.drive_gain = message.drive_gain;
}

void toMessage(const cvg::OrbitalElements& elements, double angular_gain, const std::string& frame,
               sensor_msgs::Imu& message) {
  const auto delay_ns = static_cast<std::int64_t>(std::llround(1e9 * elements.group_delay));
  message.header.stamp =
      timeFromNanoseconds(std::max<std::int64_t>(0, elements.stamp.end_ns - delay_ns));
  message.header.frame_id = frame;
  const double angle = -elements.angle / angular_gain;
  message.orientation.x = 0.0;
  message.orientation.y = 0.0;
  message.orientation.z = std::sin(0.5 * angle);
  message.orientation.w = std::cos(0.5 * angle);
  message.angular_velocity.z = -elements.angle_rate / angular_gain;
  message.linear_acceleration_covariance[0] = -1.0;
}

}  // namespace ring_gyro::bridge
