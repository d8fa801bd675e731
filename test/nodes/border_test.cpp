// Nodes that are sent what cannot be: they refuse it, say why, and live on; a slow reader costs
// neither memory nor, in lockstep, a message.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/nodes/output.h"
#include "ring_gyro/nodes/reader_wait.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/node_configuration.h"
#include "ring_gyro/ros/topics.h"
#include "ring_gyro/simulation/closed_loop.h"

extern char** environ;

namespace ring_gyro::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kPeriod = 100;  // blocks
std::string program;                    // this one

template <typename Condition>
bool waitFor(Condition condition, double seconds = 30.0) {
  const auto give_up =
      std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<int>(1e3 * seconds));
  while (!condition()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return true;
}

/// Nothing more comes.
void settle() {
  waitFor([] { return false; }, 0.2);
}

template <typename Message>
class Collected {
 public:
  Collected(ros::NodeHandle& handle, const char* topic)
      : subscriber_(handle.subscribe<Message>(
            topic, 0,
            boost::function<void(const boost::shared_ptr<const Message>&)>(
                [this](const boost::shared_ptr<const Message>& message) {
                  messages.push_back(*message);
                }))) {}
  bool connected() const { return subscriber_.getNumPublishers() > 0; }

  std::vector<Message> messages;

 private:
  ros::Subscriber subscriber_;
};

/// What a node says of itself on /diagnostics.
class Diagnostics {
 public:
  Diagnostics() : collected_(handle_, "/diagnostics") {}

  /// Waits until a report of the node holds.
  template <typename Condition>
  bool waitUntil(const std::string& node, Condition condition) {
    return waitFor([&] {
      bool found = false;
      for (const auto& array : collected_.messages) {
        for (const auto& status : array.status) {
          if (status.name.find(node) != std::string::npos && condition(status)) found = true;
        }
      }
      collected_.messages.clear();
      return found;
    });
  }
  static std::string valueOf(const diagnostic_msgs::DiagnosticStatus& status,
                             const std::string& key) {
    for (const auto& value : status.values) {
      if (value.key == key) return value.value;
    }
    return "";
  }

 private:
  ros::NodeHandle handle_;
  Collected<diagnostic_msgs::DiagnosticArray> collected_;
};

/// Says on behalf of the plant that a session has ended, latched.
class EndOfRun {
 public:
  EndOfRun(ros::NodeHandle& handle, std::uint32_t session, std::uint64_t last)
      : publisher_(handle.advertise<ring_gyro::EndOfRun>(bridge::topics::kEndOfRun, 1, true)) {
    ring_gyro::EndOfRun message;
    message.header.stamp = ros::Time(1.0);
    message.session = session;
    message.last_sequence = last;
    publisher_.publish(message);
    waitFor([this] { return publisher_.getNumSubscribers() > 0; });
    settle();
  }

 private:
  ros::Publisher publisher_;
};

/// The gyroscope for a node of the loops, in this process.
class LoopsTest : public ::testing::Test {
 protected:
  explicit LoopsTest(const std::string& name = "loops")
      : handle_(name),
        configuration_(
            bridge::readNodeConfiguration(ros::NodeHandle(handle_, "control_loops")).loop),
        plant_(configuration_.plant, configuration_.converter, 1, kSession, 1000000000),
        publisher_(
            handle_.advertise<ring_gyro::DisplacementBlock>(bridge::topics::kDisplacement, 0)),
        commands_(handle_, bridge::topics::kDriveCommand),
        elements_(handle_, bridge::topics::kOrbitalElements) {
    EXPECT_TRUE(waitFor([this] {
      return publisher_.getNumSubscribers() > 0 && commands_.connected() && elements_.connected();
    }));
  }

  static constexpr std::uint32_t kSession = 5;

  /// The next block of the plant.
  ring_gyro::DisplacementBlock next() {
    ring_gyro::DisplacementBlock message;
    bridge::toMessage(any_ ? plant_.step(command_) : plant_.start(), message);
    any_ = true;
    return message;
  }
  /// Sends a block and takes the answer.
  void answer(const ring_gyro::DisplacementBlock& block) {
    const std::size_t before = commands_.messages.size();
    publisher_.publish(block);
    ASSERT_TRUE(waitFor([&] { return commands_.messages.size() > before; }))
        << "no answer to block " << block.sequence;
    ASSERT_EQ(commands_.messages.back().answers_sequence, block.sequence);
    ASSERT_EQ(commands_.messages.back().session, block.session);
    bridge::fromMessage(commands_.messages.back(), command_);
  }
  void run(std::uint64_t blocks) {
    for (std::uint64_t i = 0; i < blocks && !HasFatalFailure(); ++i) answer(next());
  }
  void expectNoAnswer(const ring_gyro::DisplacementBlock& block) {
    const std::size_t before = commands_.messages.size();
    publisher_.publish(block);
    settle();
    EXPECT_EQ(commands_.messages.size(), before);
  }

  ros::NodeHandle handle_;
  cvg::LoopConfiguration configuration_;
  cvg::PlantSimulator plant_;
  cvg::DriveCommand command_;
  bool any_ = false;
  ros::Publisher publisher_;
  Collected<ring_gyro::DriveCommand> commands_;
  Collected<ring_gyro::OrbitalElements> elements_;
};

TEST_F(LoopsTest, LiveOnWhateverABlockSays) {
  Diagnostics diagnostics;
  // Latched from an earlier run, before any data.
  const EndOfRun early(handle_, kSession - 1, 3);
  run(50);

  const auto wrong = [this](const char* what, auto change) {
    SCOPED_TRACE(what);
    ring_gyro::DisplacementBlock block = next();
    const double phase = block.reference_phase;
    const double frequency = block.reference_frequency;
    change(block);
    answer(block);
    // As the plant goes on from the last command, the phase of the NCO is that of a good block.
    EXPECT_DOUBLE_EQ(command_.reference_phase,
                     cvg::wrapToPi(phase + frequency * configuration_.converter.blockDuration()));
    EXPECT_GT(command_.reference_frequency, 0.0);
    EXPECT_TRUE(command_.envelope.allFinite());
  };
  wrong("phase", [](auto& block) { block.reference_phase = kNaN; });
  wrong("frequency", [](auto& block) { block.reference_frequency = kNaN; });
  wrong("sign", [](auto& block) { block.reference_frequency *= -1.0; });
  wrong("huge", [](auto& block) { block.reference_phase = 1e300; });
  wrong("duration", [](auto& block) { block.duration = 0; });
  wrong("count", [](auto& block) { block.saturated_samples = 4000000; });
  wrong("samples", [](auto& block) { block.x[7] = kNaN; });
  wrong("lengths", [](auto& block) { block.y.resize(3); });
  wrong("none", [](auto& block) { block.x.clear(); });
  ring_gyro::DisplacementBlock unstamped = next();
  const ros::Time stamp = unstamped.header.stamp;
  unstamped.header.stamp = ros::Time();
  expectNoAnswer(unstamped);
  unstamped.header.stamp = stamp;
  answer(unstamped);
  run(20);
  // They go in bursts.
  ASSERT_TRUE(waitFor([this] { return elements_.messages.size() == 80; }));
  for (const ring_gyro::OrbitalElements& elements : elements_.messages) {
    EXPECT_TRUE(std::isfinite(elements.a + elements.theta + elements.angle_rate));
    if (elements.sequence >= 50 && elements.sequence < 59) {
      EXPECT_TRUE(elements.status.invalid_samples) << elements.sequence;
    }
  }

  // An end that is none of its own, live.
  const EndOfRun other(handle_, kSession + 1, 3);
  run(20);
  EXPECT_TRUE(diagnostics.waitUntil("loops/control_loops", [](const auto& status) {
    return Diagnostics::valueOf(status, "ends of other sessions") == "2" &&
           Diagnostics::valueOf(status, "refused messages") == "7" &&
           Diagnostics::valueOf(status, "refused displacement: reference_phase is not finite") ==
               "1";
  }));
}

class CompensatedLoopsTest : public LoopsTest {
 protected:
  CompensatedLoopsTest()
      : LoopsTest("compensated"),
        decisions_(handle_.advertise<ring_gyro::CompensationGains>(
            bridge::topics::kCompensationGains, 0, true)) {}

  void decide(std::uint64_t effective_sequence) {
    ring_gyro::CompensationGains message;
    message.header.stamp = ros::Time(1.0);
    message.session = kSession;
    message.effective_sequence = effective_sequence;
    message.data_sequence = effective_sequence - kPeriod - 1;
    decisions_.publish(message);
  }

  ros::Publisher decisions_;
};

TEST_F(CompensatedLoopsTest, NothingButItsOwnBlockWaitsForADecision) {
  run(2 * kPeriod - 1);
  const ring_gyro::DisplacementBlock border = next();  // its drive acts in block 200
  expectNoAnswer(border);
  // While it waits: the same again, an older one, one of another plant.
  expectNoAnswer(border);
  ring_gyro::DisplacementBlock old = border;
  old.sequence -= 50;
  old.header.stamp -= ros::Duration(0.05);
  expectNoAnswer(old);
  ring_gyro::DisplacementBlock foreign = border;
  foreign.session += 1;
  expectNoAnswer(foreign);
  // Decisions that cannot be used do not let it go.
  ring_gyro::CompensationGains wrong;
  wrong.header.stamp = ros::Time(1.0);
  wrong.session = kSession;
  wrong.effective_sequence = 2 * kPeriod;
  wrong.gain1 = kNaN;
  decisions_.publish(wrong);
  wrong.gain1 = 0.0;
  wrong.state = 200;
  decisions_.publish(wrong);
  settle();
  EXPECT_EQ(commands_.messages.size(), 2 * kPeriod - 1);
  decide(2 * kPeriod);
  ASSERT_TRUE(waitFor([this] { return commands_.messages.size() == 2 * kPeriod; }));
  EXPECT_EQ(commands_.messages.back().answers_sequence, border.sequence);
  bridge::fromMessage(commands_.messages.back(), command_);

  // Now that the decision is used up: the same block again, and those of others at the border.
  expectNoAnswer(border);
  run(50);
  expectNoAnswer(border);
  foreign.sequence = 3 * kPeriod - 1;
  foreign.header.stamp += ros::Duration(0.1);
  foreign.session += 7;
  expectNoAnswer(foreign);
  run(40);
  decide(3 * kPeriod);
  run(30);
  EXPECT_EQ(commands_.messages.size(), 2 * kPeriod + 120);

  // A plant that is started again begins with its first block, and the other one is left.
  ring_gyro::DisplacementBlock first = next();
  const ring_gyro::DisplacementBlock going_on = first;
  first.session = kSession + 20;
  first.sequence = 0;
  answer(first);
  expectNoAnswer(going_on);
}

TEST(IdentifierBorder, SaysWhyNoBlockCanBeUsed) {
  ros::NodeHandle handle("identifier");
  Diagnostics diagnostics;
  const ros::Publisher elements =
      handle.advertise<ring_gyro::OrbitalElements>(bridge::topics::kOrbitalElements, 0);
  const ros::Publisher gains =
      handle.advertise<ring_gyro::ControlGains>(bridge::topics::kControlGains, 0);
  ASSERT_TRUE(
      waitFor([&] { return elements.getNumSubscribers() > 0 && gains.getNumSubscribers() > 0; }));
  const EndOfRun early(handle, 4, 1);
  std::uint64_t sequence = 0;
  const auto send = [&](auto change) {
    for (int i = 0; i < 50; ++i, ++sequence) {
      ring_gyro::OrbitalElements e;
      ring_gyro::ControlGains g;
      e.header.stamp = g.header.stamp = ros::Time(1.0 + 1e-3 * static_cast<double>(sequence));
      e.session = g.session = 5;
      e.sequence = g.sequence = sequence;
      e.duration = g.duration = 1000000;
      e.a = 1.0;
      g.reference_frequency = 9e4;
      e.status.amplitude_locked = e.status.quadrature_locked = e.status.phase_locked = true;
      g.status = e.status;
      change(e, g);
      elements.publish(e);
      gains.publish(g);
    }
  };
  const auto expect = [&](const std::string& summary) {
    EXPECT_TRUE(diagnostics.waitUntil("identifier/ekf_identifier", [&](const auto& status) {
      return status.level == diagnostic_msgs::DiagnosticStatus::WARN &&
             status.message.find("none of the last ") == 0 &&
             status.message.find(summary) != std::string::npos;
    })) << summary;
  };
  send([](auto&, auto& g) {
    g.sustain.x_real = 0.1;
    g.drive.x_real = 0.2;
  });
  expect("whose drive contradicts its parts");
  send([](auto& e, auto&) { e.theta = kNaN; });
  expect("not finite");
  send([](auto&, auto& g) { g.reference_frequency = 0.0; });
  expect("without a reference frequency");
  send([](auto& e, auto&) { e.status.phase_locked = false; });
  expect("not locked");
  send([](auto&, auto&) {});
  EXPECT_TRUE(diagnostics.waitUntil("identifier/ekf_identifier", [](const auto& status) {
    return Diagnostics::valueOf(status, "usable blocks") == "50" &&
           Diagnostics::valueOf(status, "unusable blocks") == "200" &&
           Diagnostics::valueOf(status, "blocks not locked") == "50" &&
           Diagnostics::valueOf(status, "ends of other sessions") == "1" &&
           Diagnostics::valueOf(status,
                                "refused control_gains: drive is not the sum of its parts") == "50";
  }));
}

TEST(InjectorBorder, DecidesOnAnEstimateThatCannotBe) {
  ros::NodeHandle handle("injector");
  const ros::Publisher estimates =
      handle.advertise<ring_gyro::ParameterEstimate>(bridge::topics::kParameterEstimate, 0);
  Collected<ring_gyro::CompensationGains> decisions(handle, bridge::topics::kCompensationGains);
  ASSERT_TRUE(waitFor([&] { return estimates.getNumSubscribers() > 0; }));
  const EndOfRun early(handle, 4, 1);
  std::uint64_t periods = 0;
  const auto decide = [&](auto change) {
    ring_gyro::ParameterEstimate estimate;
    estimate.header.stamp = ros::Time(1.0 + static_cast<double>(++periods));
    estimate.session = 5;
    estimate.last_sequence = periods * kPeriod - 1;
    estimate.duration = 1000000;
    estimate.used_blocks = periods * kPeriod;
    estimate.value = {1.0, 0.0, 0.02, 0.03, 0.0, 0.0, 1.1e5};
    for (int i = 0; i < 7; ++i) estimate.covariance[8 * i] = 1e-12;
    estimate.converged = true;
    change(estimate);
    const std::size_t before = decisions.messages.size();
    estimates.publish(estimate);
    EXPECT_TRUE(waitFor([&] { return decisions.messages.size() > before; }));
    return decisions.messages.back();
  };
  const auto good = decide([](auto&) {});
  EXPECT_EQ(good.state, ring_gyro::CompensationGains::TRACKING);
  EXPECT_GT(good.gamma1, 0.0);
  const auto expectHeld = [&](const ring_gyro::CompensationGains& decision) {
    EXPECT_EQ(decision.state, ring_gyro::CompensationGains::WAITING);
    EXPECT_EQ(decision.gain1, good.gain1);
    EXPECT_EQ(decision.effective_sequence, (periods + 1) * kPeriod);
  };
  expectHeld(decide([](auto& e) { e.value[3] = kNaN; }));
  expectHeld(decide([](auto& e) { e.innovation[1] = kNaN; }));
  expectHeld(decide([](auto& e) { e.covariance[8] = -1.0; }));
  expectHeld(decide([](auto& e) { e.duration = 0; }));
  EXPECT_GT(decide([](auto&) {}).gamma1, good.gamma1);
  const EndOfRun other(handle, 6, 1);
  decide([](auto&) {});
}

TEST(PlantBorder, CoastsOverADriveThatCannotBe) {
  ros::NodeHandle handle("plant");
  Diagnostics diagnostics;
  const ros::Publisher commands =
      handle.advertise<ring_gyro::DriveCommand>(bridge::topics::kDriveCommand, 0);
  ASSERT_TRUE(waitFor([&] { return commands.getNumSubscribers() > 0; }));
  Collected<ring_gyro::DisplacementBlock> blocks(handle, bridge::topics::kDisplacement);
  ASSERT_TRUE(waitFor([&] { return blocks.messages.size() == 1; }));
  ring_gyro::DriveCommand good;
  good.header.stamp = blocks.messages.back().header.stamp;
  good.session = 7;
  good.reference_frequency = 88000.0;
  good.envelope.x_real = 1.0;
  const auto answer = [&](auto change) {
    const std::size_t before = blocks.messages.size();
    ring_gyro::DriveCommand command = good;
    command.answers_sequence = blocks.messages.back().sequence;
    change(command);
    commands.publish(command);
    EXPECT_TRUE(waitFor([&] { return blocks.messages.size() > before; }));
    return blocks.messages.back();
  };
  EXPECT_EQ(answer([](auto&) {}).drive_answers_sequence, 0u);
  for (const auto& block : {answer([](auto& c) { c.reference_phase = kNaN; }),
                            answer([](auto& c) { c.envelope.y_imag = kNaN; }),
                            answer([](auto& c) { c.reference_frequency = -1.0; }),
                            answer([](auto& c) { c.table_rate = kNaN; })}) {
    EXPECT_EQ(block.drive_answers_sequence, 0u) << "the last good drive goes on";
    EXPECT_EQ(block.reference_frequency, 88000.0);
    EXPECT_TRUE(std::isfinite(block.reference_phase + block.x[0]));
  }
  const std::size_t before = blocks.messages.size();
  const auto ignored = [&](auto change) {
    ring_gyro::DriveCommand command = good;
    command.answers_sequence = blocks.messages.back().sequence;
    change(command);
    commands.publish(command);
    settle();
    EXPECT_EQ(blocks.messages.size(), before);
  };
  ignored([](auto& c) { c.session = 8; });
  ignored([](auto& c) { c.answers_sequence -= 1; });
  ignored([](auto& c) { c.answers_sequence += 1; });
  EXPECT_EQ(answer([](auto&) {}).sequence, before);
  EXPECT_TRUE(diagnostics.waitUntil("plant/plant_simulator", [](const auto& status) {
    return Diagnostics::valueOf(status, "refused messages") == "7" &&
           Diagnostics::valueOf(status, "refused drive_command: of another session") == "1" &&
           Diagnostics::valueOf(status, "refused drive_command: table_rate is not finite") == "1";
  }));
}

std::size_t residentBytes() {
  std::FILE* const file = std::fopen("/proc/self/statm", "r");
  unsigned long size = 0, resident = 0;
  const int read = std::fscanf(file, "%lu %lu", &size, &resident);
  std::fclose(file);
  return read == 2 ? resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) : 0;
}

TEST(Output, IsBoundedAndHoldsALockstepRunForItsSlowestReader) {
  ros::NodeHandle handle;
  const nodes::Output output = nodes::Output::advertise<ring_gyro::ControlGains>(handle, "slow");
  char reader_option[] = "--reader";
  char* const arguments[] = {&program[0], reader_option, nullptr};
  pid_t reader = 0;
  ASSERT_EQ(posix_spawn(&reader, program.c_str(), nullptr, nullptr, arguments, environ), 0);
  ASSERT_TRUE(waitFor([&] { return output.subscribers() > 0; }));
  cvg::NodeParameters parameters;
  parameters.lockstep_timeout = 1.0;
  int resumed = 0;
  nodes::ReaderWait wait(handle, parameters, {output}, [&] { ++resumed; });
  const auto message = boost::make_shared<ring_gyro::ControlGains>();
  message->header.stamp = ros::Time(1.0);
  EXPECT_FALSE(wait.mustHold());

  // A reader that takes its time: the run waits for it, and nothing is lost.
  kill(reader, SIGSTOP);
  int published = 0;
  while (!wait.mustHold() && published < 1000000) {
    output.publish(message);
    ++published;
    // The sockets take what they can.
    if (published % 500 == 0) waitFor([&] { return output.waiting() == 0; }, 0.02);
  }
  EXPECT_TRUE(wait.holding());
  EXPECT_EQ(output.waiting(), nodes::kOutputQueue / 2);
  EXPECT_EQ(output.overflows(), 0u);
  kill(reader, SIGCONT);
  EXPECT_TRUE(waitFor([&] { return resumed == 1; }));
  EXPECT_FALSE(wait.holding());
  EXPECT_TRUE(waitFor([&] { return output.waiting() == 0; }));

  // One that takes nothing at all: the run goes on, and what the reader loses is counted.
  kill(reader, SIGSTOP);
  const std::size_t before = residentBytes();
  for (published = 0; published < 1000000 && output.overflows() < 100000; ++published) {
    output.publish(message);
  }
  EXPECT_EQ(output.overflows(), 100000u);
  EXPECT_TRUE(waitFor([&] { return output.waiting() <= nodes::kOutputQueue + 1; }));
  EXPECT_LT(residentBytes(), before + 50000000u);
  EXPECT_TRUE(wait.mustHold());
  EXPECT_TRUE(waitFor([&] { return resumed == 2; }));
  EXPECT_FALSE(wait.mustHold()) << "it has been given up";
  parameters.lockstep = false;
  nodes::ReaderWait real_time(handle, parameters, {output}, [] {});
  EXPECT_FALSE(real_time.mustHold());
  kill(reader, SIGCONT);
  kill(reader, SIGKILL);
  waitpid(reader, nullptr, 0);
}

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ring_gyro::test::program = argv[0];
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1 && std::string(argv[1]) == "--reader") {
    ros::init(argc, argv, "slow_reader");
    ros::NodeHandle handle;
    const boost::function<void(const ring_gyro::ControlGains::ConstPtr&)> nothing =
        [](const auto&) {};
    const ros::Subscriber subscriber =
        handle.subscribe<ring_gyro::ControlGains>("slow", 1, nothing);
    ros::spin();
    return 0;
  }
  ros::init(argc, argv, "border_test");
  return RUN_ALL_TESTS();
}
