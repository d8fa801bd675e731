// The border between messages and the core: whatever number of whatever field cannot be, it is
// found there, and its field is named.

#include "ring_gyro/ros/message_checks.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/identification/filter/block_chain.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Walks through a message as its serialiser does and collects every double, so that none can be
/// forgotten here.
class Numbers {
 public:
  template <typename Message>
  explicit Numbers(Message& message) {
    ros::serialization::Serializer<Message>::template allInOne<Numbers, Message&>(*this, message);
  }
  const std::vector<double*>& all() const { return numbers_; }

  void next(double& number) { numbers_.push_back(&number); }
  void next(std::vector<double>& list) {
    for (double& number : list) next(number);
  }
  template <std::size_t size>
  void next(boost::array<double, size>& list) {
    for (double& number : list) next(number);
  }
  template <typename Field>
  void next(Field& field) {
    if constexpr (ros::message_traits::IsMessage<Field>::value) {
      ros::serialization::Serializer<Field>::template allInOne<Numbers, Field&>(*this, field);
    }
  }

 private:
  std::vector<double*> numbers_;
};

/// All messages of a second of the loop, locked or not.
struct Messages {
  ring_gyro::DisplacementBlock displacement;
  ring_gyro::DriveCommand command;
  ring_gyro::OrbitalElements elements;
  ring_gyro::ControlGains gains;
  ring_gyro::ParameterEstimate estimate;
  ring_gyro::CompensationGains decision;
  ring_gyro::PlantTruth truth;
};

cvg::LoopConfiguration configuration() {
  return cvg::readConfigurationFile(std::string(RING_GYRO_CONFIG_DIR) + "/paper_simulation.yaml",
                                    {"control/compensation=true", "control/virtual_rate=1.0"});
}

template <typename OnBlock>
Messages runLoop(std::uint64_t blocks, OnBlock on_block) {
  cvg::ClosedLoop loop(configuration());
  Messages messages;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const cvg::LoopRecord record = loop.step();
    bridge::toMessage(record.displacement, messages.displacement);
    bridge::toMessage(record.loops.command, record.displacement.stamp, messages.command);
    bridge::toMessage(record.loops.elements, messages.elements);
    bridge::toMessage(record.loops.gains, messages.gains);
    bridge::toMessage(record.truth(), messages.truth);
    if (record.estimate) {
      bridge::toMessage(*record.estimate, messages.estimate);
      bridge::toMessage(*record.decision, messages.estimate.header.stamp, messages.decision);
    }
    on_block(messages, record.estimate != nullptr);
  }
  return messages;
}

const Messages& good() {
  static const Messages messages = runLoop(1000, [](const Messages&, bool) {});
  return messages;
}

ring_gyro::CalibrationCommand goodCommand() {
  cvg::CalibrationCommand command;
  command.session = 1;
  command.effective_sequence = 300;
  command.settings.virtual_rate = 0.7;
  command.settings.amplitude_modulation = 0.1;
  command.settings.amplitude_modulation_frequency = 0.2;
  command.settings.corrections.drift = {0.1, {0.2, 0.3}, {0.4}};
  command.settings.corrections.angle_map = {0.1, {0.2}, {0.3, 0.4, 0.5}};
  command.leg = "survey";
  command.time_left = 12.0;
  ring_gyro::CalibrationCommand message;
  bridge::toMessage(command, {1, 199, 200000000, 1000000}, message);
  return message;
}

TEST(MessageChecks, FindNothingInWhatTheLoopSends) {
  runLoop(3000, [](const Messages& m, bool estimate) {
    ASSERT_FALSE(bridge::faultOf(m.displacement)) << bridge::faultOf(m.displacement).text;
    ASSERT_FALSE(bridge::faultOf(m.command)) << bridge::faultOf(m.command).text;
    ASSERT_FALSE(bridge::faultOf(m.elements)) << bridge::faultOf(m.elements).text;
    ASSERT_FALSE(bridge::faultOf(m.gains)) << bridge::faultOf(m.gains).text;
    ASSERT_FALSE(bridge::faultOf(m.truth)) << bridge::faultOf(m.truth).text;
    if (!estimate) return;
    ASSERT_FALSE(bridge::faultOf(m.estimate)) << bridge::faultOf(m.estimate).text;
    ASSERT_FALSE(bridge::faultOf(m.decision)) << bridge::faultOf(m.decision).text;
  });
  EXPECT_FALSE(bridge::faultOf(goodCommand()));
}

template <typename Message>
void expectEveryNumberChecked(Message message, std::initializer_list<double> wrong_values) {
  ASSERT_FALSE(bridge::faultOf(message)) << bridge::faultOf(message).text;
  const Numbers numbers(message);
  ASSERT_FALSE(numbers.all().empty());
  for (std::size_t i = 0; i < numbers.all().size(); ++i) {
    const double right = *numbers.all()[i];
    for (const double wrong : wrong_values) {
      *numbers.all()[i] = wrong;
      const bridge::MessageFault fault = bridge::faultOf(message);
      EXPECT_EQ(fault.kind, cvg::Refusal::kNotFinite) << "number " << i << " = " << wrong;
      EXPECT_EQ(fault.text.rfind(fault.field, 0), 0u) << fault.text;
      EXPECT_NE(std::string(fault.field), "");
      EXPECT_NE(std::string(fault.reason), "");
    }
    *numbers.all()[i] = right;
  }
}

TEST(MessageChecks, LookAtEveryNumberOfEveryMessage) {
  const auto any_size = {kNaN, kInfinity, -kInfinity, 1e300, -1e13};
  ring_gyro::DisplacementBlock displacement = good().displacement;
  displacement.x.clear();  // samples are the loops' affair: they coast
  displacement.y.clear();
  expectEveryNumberChecked(displacement, any_size);
  expectEveryNumberChecked(good().command, any_size);
  expectEveryNumberChecked(good().elements, any_size);
  expectEveryNumberChecked(good().gains, any_size);
  expectEveryNumberChecked(good().decision, any_size);
  expectEveryNumberChecked(good().truth, any_size);
  expectEveryNumberChecked(goodCommand(), any_size);
  // Its variances are 1e30 while nothing is known.
  expectEveryNumberChecked(good().estimate, {kNaN, kInfinity, -kInfinity});
}

template <typename Message, typename Change>
void expectImpossible(Message message, const std::string& field, Change change) {
  change(message);
  const bridge::MessageFault fault = bridge::faultOf(message);
  EXPECT_EQ(fault.kind, cvg::Refusal::kImpossible) << field;
  EXPECT_EQ(fault.field, field);
  EXPECT_NE(fault.text.find("allowed: "), std::string::npos) << fault.text;
}

TEST(MessageChecks, RefuseWhatCannotBe) {
  const Messages& m = good();
  expectImpossible(m.elements, "group_delay", [](auto& e) { e.group_delay = -1e-6; });
  expectImpossible(m.elements, "duration", [](auto& e) { e.duration = 0; });
  expectImpossible(m.elements, "duration",
                   [](auto& e) { e.duration = static_cast<std::uint64_t>(-1000000); });
  expectImpossible(m.gains, "reference_frequency", [](auto& g) { g.reference_frequency = -1.0; });
  expectImpossible(m.gains, "duration", [](auto& g) { g.duration = 0; });
  expectImpossible(m.displacement, "reference_frequency",
                   [](auto& d) { d.reference_frequency = 0.0; });
  expectImpossible(m.displacement, "reference_frequency",
                   [](auto& d) { d.reference_frequency = -89000.0; });
  expectImpossible(m.displacement, "saturated_samples", [](auto& d) { d.saturated_samples = 401; });
  expectImpossible(m.displacement, "clipped_drive_samples",
                   [](auto& d) { d.clipped_drive_samples = 401; });
  expectImpossible(m.displacement, "duration", [](auto& d) { d.duration = 0; });
  expectImpossible(m.command, "reference_frequency", [](auto& c) { c.reference_frequency = 0.0; });
  expectImpossible(m.estimate, "covariance", [](auto& e) { e.covariance[48] = -1.0; });
  expectImpossible(m.estimate, "sigma", [](auto& e) { e.sigma[2] = -1.0; });
  expectImpossible(m.estimate, "normalised_innovation_squared",
                   [](auto& e) { e.normalised_innovation_squared = -1.0; });
  expectImpossible(m.estimate, "first_sequence", [](auto& e) { e.first_sequence = 100000; });
  expectImpossible(m.estimate, "duration", [](auto& e) { e.duration = 0; });
  expectImpossible(m.decision, "state", [](auto& d) { d.state = 5; });
  expectImpossible(m.decision, "effective_sequence",
                   [](auto& d) { d.effective_sequence = d.data_sequence; });
  expectImpossible(m.truth, "quality_factor", [](auto& t) { t.quality_factor = 0.0; });
  expectImpossible(goodCommand(), "amplitude_modulation",
                   [](auto& c) { c.amplitude_modulation = -1.0; });
  expectImpossible(goodCommand(), "amplitude_modulation_frequency",
                   [](auto& c) { c.amplitude_modulation_frequency = -0.1; });
  expectImpossible(goodCommand(), "calibration.angle_map_sine",
                   [](auto& c) { c.calibration.angle_map_sine.assign(1000, 0.0); });
  // Before the first drive there is no reference.
  ring_gyro::DisplacementBlock first = m.displacement;
  first.driven = false;
  first.reference_frequency = 0.0;
  EXPECT_FALSE(bridge::faultOf(first));
}

TEST(MessageChecks, DriveIsTheSumOfItsPartsOrAllThatThereIs) {
  ring_gyro::ControlGains message = good().gains;
  cvg::ControlGains expected;
  bridge::fromMessage(message, expected);
  for (double ring_gyro::Envelope::*part :
       {&ring_gyro::Envelope::x_real, &ring_gyro::Envelope::x_imag, &ring_gyro::Envelope::y_real,
        &ring_gyro::Envelope::y_imag}) {
    message = good().gains;
    message.drive.*part *= 1.0 + 1e-13;  // rounding
    EXPECT_FALSE(bridge::faultOf(message));
    message.drive.*part += 1e-3;
    const bridge::MessageFault fault = bridge::faultOf(message);
    EXPECT_EQ(fault.kind, cvg::Refusal::kContradiction);
    EXPECT_EQ(std::string(fault.field), "drive");
    EXPECT_NE(fault.text.find("is not the sum of its parts, ("), std::string::npos) << fault.text;
  }
  message = good().gains;
  message.drive = {};
  EXPECT_EQ(bridge::faultOf(message).kind, cvg::Refusal::kContradiction);
  // Only the total.
  message = good().gains;
  message.sustain = message.quadrature = message.steering = message.compensation = {};
  EXPECT_FALSE(bridge::faultOf(message));
  cvg::ControlGains gains;
  bridge::fromMessage(message, gains);
  EXPECT_EQ(gains.drive.total(), expected.drive.total());
}

TEST(MessageChecks, OfARefusedMessageOnlyTheBlockIsKnown) {
  ring_gyro::OrbitalElements message = good().elements;
  message.angle_rate = kNaN;
  cvg::OrbitalElements elements;
  EXPECT_TRUE(bridge::readChecked(message, elements));
  EXPECT_EQ(elements.stamp.sequence, message.sequence);
  EXPECT_FALSE(elements.status.usable());
  EXPECT_EQ(elements.status.refused, cvg::Refusal::kNotFinite);
  EXPECT_EQ(elements.angle_rate, 0.0);
  EXPECT_EQ(elements.orbit.a, 0.0);
  ring_gyro::ControlGains contradictory = good().gains;
  contradictory.drive.x_real += 1.0;
  cvg::ControlGains gains;
  EXPECT_TRUE(bridge::readChecked(contradictory, gains));
  EXPECT_EQ(gains.status.refused, cvg::Refusal::kContradiction);
  EXPECT_EQ(gains.drive.total().norm(), 0.0);
}

/// What is counted as usable is what the filter uses: of any one block, whatever is wrong with it.
TEST(BlockUse, AgreesWithWhatTheChainAdmits) {
  cvg::OrbitalElements good_elements;
  bridge::fromMessage(good().elements, good_elements);
  cvg::ControlGains good_gains;
  bridge::fromMessage(good().gains, good_gains);
  good_elements.status = good_gains.status = cvg::LoopStatus{true, true, true, false, false, false};
  good_elements.group_delay = 0.4e-3;  // less than half a block: no memory
  std::mt19937 random(5);
  int admitted = 0;
  cvg::BlockUseCounts seen;
  for (int i = 0; i < 20000; ++i) {
    cvg::OrbitalElements e = good_elements;
    cvg::ControlGains g = good_gains;
    const auto strange = [&random] {
      const std::array<double, 8> values = {0.0, -1.0, kNaN, kInfinity, 1e12, 0.05, 9e11, -5e11};
      return values[random() % values.size()];
    };
    const std::array<double*, 8> numbers = {&e.orbit.a,
                                            &e.orbit.b,
                                            &e.orbit.theta,
                                            &e.group_delay,
                                            &g.reference_frequency,
                                            &g.reference_phase,
                                            &g.compensation.gain1,
                                            &e.orbit.phi};
    if (random() % 2 == 0) *numbers[random() % numbers.size()] = strange();
    if (random() % 8 == 0) g.drive.sustain[0] = strange();
    const std::array<bool*, 6> flags = {&e.status.phase_locked,        &g.status.amplitude_locked,
                                        &e.status.invalid_samples,     &g.status.drive_saturated,
                                        &e.status.converter_saturated, &g.status.invalid_samples};
    if (random() % 4 == 0) {
      bool& flag = *flags[random() % flags.size()];
      flag = !flag;
    }
    if (random() % 16 == 0) e.status.refused = static_cast<cvg::Refusal>(random() % 4);
    if (random() % 16 == 0) e.stamp.duration_ns += 1;
    if (random() % 32 == 0) ++g.stamp.sequence;
    if (random() % 16 == 0) e.group_delay = 0.7e-3;  // a block before must have been there
    cvg::BlockChain chain(1000000);
    const cvg::BlockUse use = chain.admit(e, g, 0.0);
    if (use == cvg::BlockUse::kAfterBreak) {
      EXPECT_GT(e.group_delay, 0.0);
      EXPECT_EQ(cvg::useOf(e, g, 1000000), cvg::BlockUse::kUsable) << i;
    } else if (use != cvg::BlockUse::kGroupDelay && !(e.group_delay < 0.0)) {
      EXPECT_EQ(use, cvg::useOf(e, g, 1000000)) << i;
    }
    if (use == cvg::BlockUse::kUsable || use == cvg::BlockUse::kAfterBreak) ++admitted;
    seen.add(use);
  }
  EXPECT_GT(admitted, 1000);
  for (std::size_t use = 0; use < seen.blocks.size(); ++use) EXPECT_GT(seen.blocks[use], 0u) << use;
  EXPECT_EQ(seen.usable() + seen.unusable(), 20000u);
  EXPECT_EQ((seen - seen).unusable(), 0u);
}

}  // namespace
}  // namespace ring_gyro::test
