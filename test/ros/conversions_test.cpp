#include "ring_gyro/ros/conversions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/configuration/parameter_text.h"
#include "ring_gyro/ros/message_pool.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ros/message_bytes.h"

namespace ring_gyro::test {
namespace {

/// Values whose bits are easily lost: all exponents, both zeros, the smallest.
class Values {
 public:
  double next() {
    switch (generator_() % 16) {
      case 0:
        return -0.0;
      case 1:
        return std::numeric_limits<double>::denorm_min();
      default:
        return std::ldexp(mantissa_(generator_), static_cast<int>(generator_() % 200) - 100);
    }
  }
  std::complex<double> nextComplex() {
    const double real = next();
    return {real, next()};
  }
  Eigen::Vector2cd nextEnvelope() {
    const std::complex<double> x = nextComplex();
    return {x, nextComplex()};
  }
  bool nextFlag() { return generator_() % 2 == 0; }
  std::uint64_t nextCount() { return generator_(); }
  cvg::BlockStamp nextStamp() {
    cvg::BlockStamp stamp;
    stamp.session = static_cast<std::uint32_t>(generator_());
    stamp.sequence = generator_();
    stamp.end_ns = static_cast<std::int64_t>(generator_() % 4000000000000000000ull);
    stamp.duration_ns = static_cast<std::int64_t>(generator_() % 1000000000ull);
    return stamp;
  }
  cvg::LoopStatus nextStatus() {
    cvg::LoopStatus status;
    status.amplitude_locked = nextFlag();
    status.quadrature_locked = nextFlag();
    status.phase_locked = nextFlag();
    status.invalid_samples = nextFlag();
    status.converter_saturated = nextFlag();
    status.drive_saturated = nextFlag();
    return status;
  }

 private:
  std::mt19937_64 generator_{7};
  std::uniform_real_distribution<double> mantissa_{-1.0, 1.0};
};

/// Struct to message, over a wire, to a struct and to a message again: the same bytes.
template <typename Message, typename Struct, typename ToMessage>
void expectSameBits(const Struct& original, const ToMessage& convert) {
  Message message;
  convert(original, message);
  std::vector<std::uint8_t> bytes = bytesOf(message);
  Message received;
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, received);
  Struct copy;
  bridge::fromMessage(received, copy);
  Message again;
  convert(copy, again);
  EXPECT_EQ(bytesOf(again), bytes);
}

template <typename Message, typename Struct>
void expectSameBits(const Struct& original) {
  expectSameBits<Message>(original,
                          [](const Struct& from, Message& to) { bridge::toMessage(from, to); });
}

TEST(Conversions, TimesAreWholeNanoseconds) {
  for (const std::int64_t ns : {1ll, 999999999ll, 1000000000ll, 1700000000123456789ll}) {
    EXPECT_EQ(bridge::nanosecondsFromTime(bridge::timeFromNanoseconds(ns)), ns);
  }
}

TEST(Conversions, DisplacementBlock) {
  Values values;
  cvg::DisplacementBlock block;
  block.stamp = values.nextStamp();
  block.drive_answers_sequence = values.nextCount();
  block.driven = true;
  block.reference_phase = values.next();
  block.reference_frequency = values.next();
  block.saturated_samples = 3;
  block.clipped_drive_samples = 7;
  for (int i = 0; i < 200; ++i) {
    block.x.push_back(values.next());
    block.y.push_back(values.next());
  }
  expectSameBits<ring_gyro::DisplacementBlock>(block);
}

TEST(Conversions, DriveCommand) {
  Values values;
  const cvg::BlockStamp answered = values.nextStamp();
  cvg::DriveCommand command;
  command.answers_sequence = answered.sequence;
  command.reference_phase = values.next();
  command.reference_frequency = values.next();
  command.envelope = values.nextEnvelope();
  command.table_rate = values.next();
  command.end_of_run = true;
  expectSameBits<ring_gyro::DriveCommand>(
      command, [&](const cvg::DriveCommand& from, ring_gyro::DriveCommand& to) {
        bridge::toMessage(from, answered, to);
      });
}

TEST(Conversions, OrbitalElements) {
  Values values;
  for (int i = 0; i < 50; ++i) {
    cvg::OrbitalElements elements;
    elements.stamp = values.nextStamp();
    elements.group_delay = values.next();
    elements.orbit = {values.next(), values.next(), 100.0 * i - 2000.0, values.next()};
    elements.theta_rate = values.next();
    elements.angle = values.next();
    elements.angle_rate = values.next();
    elements.status = values.nextStatus();
    expectSameBits<ring_gyro::OrbitalElements>(elements);
  }
}

TEST(Conversions, ControlGains) {
  Values values;
  for (int i = 0; i < 50; ++i) {
    cvg::ControlGains gains;
    gains.stamp = values.nextStamp();
    gains.reference_frequency = values.next();
    gains.reference_phase = values.next();
    gains.beta = values.next();
    gains.alpha = values.next();
    gains.virtual_rate = values.next();
    gains.compensation = {values.next(), values.next()};
    gains.drive.sustain = values.nextEnvelope();
    gains.drive.quadrature = values.nextEnvelope();
    gains.drive.steering = values.nextEnvelope();
    gains.drive.compensation = values.nextEnvelope();
    gains.status = values.nextStatus();
    expectSameBits<ring_gyro::ControlGains>(gains);
  }
}

TEST(Conversions, ParameterEstimate) {
  Values values;
  cvg::ParameterEstimate estimate;
  cvg::StateMatrix covariance;
  estimate.stamp = values.nextStamp();
  estimate.first_sequence = values.nextCount();
  estimate.used_blocks = values.nextCount();
  estimate.rejected_blocks = values.nextCount();
  estimate.lost_blocks = values.nextCount();
  estimate.updated = true;
  for (int i = 0; i < 7; ++i) {
    estimate.value[i] = values.next();
    for (int j = 0; j < 7; ++j) covariance(i, j) = values.next();
    covariance(i, i) = std::abs(covariance(i, i));
  }
  estimate.parameter_variance = covariance.diagonal().tail<5>();
  estimate.covariance.set(covariance);
  estimate.innovation = {values.next(), values.next()};
  estimate.innovation_covariance << values.next(), values.next(), values.next(), values.next();
  estimate.normalised_innovation_squared = values.next();
  estimate.residual_gamma1 = values.next();
  estimate.residual_gamma2 = values.next();
  estimate.angle_covered = values.next();
  estimate.converged = true;
  expectSameBits<ring_gyro::ParameterEstimate>(
      estimate, [&](const cvg::ParameterEstimate& from, ring_gyro::ParameterEstimate& to) {
        bridge::toMessage(from, to);
      });
  ring_gyro::ParameterEstimate message;
  bridge::toMessage(estimate, message);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(message.sigma[i], std::sqrt(covariance(i, i))) << i;
}

TEST(Conversions, CompensationDecision) {
  Values values;
  cvg::CompensationDecision decision;
  decision.session = 9;
  decision.effective_sequence = values.nextCount();
  decision.data_sequence = values.nextCount();
  decision.gains = {values.next(), values.next()};
  decision.gamma1 = values.next();
  decision.gamma2 = values.next();
  decision.state = cvg::InjectorState::kHolding;
  const ros::Time stamp(12, 34);
  expectSameBits<ring_gyro::CompensationGains>(
      decision, [&](const cvg::CompensationDecision& from, ring_gyro::CompensationGains& to) {
        bridge::toMessage(from, stamp, to);
      });
}

/// Every parameter of a calibration, so that none can be left out of the message.
cvg::Corrections anyCorrections(Values& values, int orders) {
  cvg::Corrections corrections;
  cvg::ParameterTable table;
  corrections.declare(table);
  for (const cvg::Parameter& parameter : table.parameters()) {
    if (const auto* flag = std::get_if<bool*>(&parameter.target)) **flag = values.nextFlag();
    if (const auto* number = std::get_if<double*>(&parameter.target)) **number = values.next();
    if (const auto* list = std::get_if<std::vector<double>*>(&parameter.target)) {
      for (int i = 0; i < orders; ++i) (*list)->push_back(values.next());
    }
  }
  return corrections;
}

std::string parametersOf(cvg::Corrections corrections) {
  cvg::ParameterTable table;
  corrections.declare(table);
  std::string text;
  for (const cvg::Parameter& parameter : table.parameters()) {
    text += parameter.key + ": " + cvg::valueText(parameter) + "\n";
  }
  return text;
}

TEST(Conversions, CalibrationCommand) {
  Values values;
  for (int orders = 0; orders <= 8; ++orders) {
    const cvg::BlockStamp data = values.nextStamp();
    cvg::CalibrationCommand command;
    command.session = data.session;
    command.effective_sequence = values.nextCount();
    command.leg = "identification 1 at +40 deg/s";
    command.time_left = values.next();
    command.finished = values.nextFlag();
    command.failure = orders % 2 == 0 ? "" : "the loops have not been locked";
    cvg::LoopSettings& settings = command.settings;
    settings.virtual_rate = values.next();
    settings.table_rate = values.next();
    settings.amplitude_modulation = values.next();
    settings.amplitude_modulation_frequency = values.next();
    settings.end_of_run = values.nextFlag();
    settings.corrections = anyCorrections(values, orders);
    settings.corrections.angle_map.constant = values.next();
    expectSameBits<ring_gyro::CalibrationCommand>(
        command, [&](const cvg::CalibrationCommand& from, ring_gyro::CalibrationCommand& to) {
          bridge::toMessage(from, data, to);
        });
    ring_gyro::CalibrationCommand message;
    bridge::toMessage(command, data, message);
    cvg::CalibrationCommand copy;
    bridge::fromMessage(message, copy);
    EXPECT_EQ(parametersOf(copy.settings.corrections), parametersOf(settings.corrections));
    EXPECT_EQ(message.data_sequence, data.sequence);
  }
}

TEST(Conversions, PlantTruth) {
  Values values;
  cvg::PlantTruth truth;
  truth.stamp = values.nextStamp();
  truth.envelope << std::complex<double>(0.3, -0.4), std::complex<double>(0.01, 0.7);
  truth.rotation_rate = values.next();
  truth.rotation_angle = values.next();
  truth.natural_frequency = values.next();
  truth.quality_factor = values.next();
  truth.gamma1 = values.next();
  truth.gamma2 = values.next();
  truth.mu1 = values.next();
  truth.mu2 = values.next();
  truth.drive_gain = values.next();
  expectSameBits<ring_gyro::PlantTruth>(truth);
}

TEST(Conversions, SensedRateHasTheSignOfTheCase) {
  cvg::OrbitalElements elements;
  elements.stamp = {1, 0, 5000000, 1000000};
  elements.angle = -0.37 * 0.5;  // the case has turned by half a radian
  elements.angle_rate = -0.37 * 2.0;
  sensor_msgs::Imu imu;
  bridge::toMessage(elements, 0.37, "gyro", imu);
  EXPECT_NEAR(imu.angular_velocity.z, 2.0, 1e-12);
  EXPECT_NEAR(2.0 * std::atan2(imu.orientation.z, imu.orientation.w), 0.5, 1e-12);
  EXPECT_EQ(imu.header.frame_id, "gyro");
  EXPECT_EQ(imu.linear_acceleration_covariance[0], -1.0);
  EXPECT_EQ(imu.angular_velocity_covariance[8], 0.0);
}

TEST(Conversions, SensedRateIsStampedWhenItIsValid) {
  cvg::OrbitalElements elements;
  elements.stamp = {1, 6, 1007000000, 1000000};
  elements.group_delay = 0.7125e-3;
  sensor_msgs::Imu imu;
  bridge::toMessage(elements, 1.0, "gyro", imu);
  EXPECT_EQ(bridge::nanosecondsFromTime(imu.header.stamp), 1007000000 - 712500);
  elements.stamp.end_ns = 500000;  // no time before zero
  bridge::toMessage(elements, 1.0, "gyro", imu);
  EXPECT_EQ(bridge::nanosecondsFromTime(imu.header.stamp), 0);
}

TEST(MessagePool, GivesOnlyWhatNobodyHolds) {
  bridge::MessagePool<ring_gyro::OrbitalElements> pool;
  const auto first = pool.take();
  const auto second = pool.take();
  EXPECT_NE(first, second);
  const ring_gyro::OrbitalElements* released = nullptr;
  {
    const auto third = pool.take();
    released = third.get();
  }
  EXPECT_EQ(pool.take().get(), released);
}

}  // namespace
}  // namespace ring_gyro::test
