// Identification from bags gives what the identifier gave while they were recorded.

#include "ring_gyro/ros/bag_identification.h"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "ring_gyro/ros/bag_validation.h"
#include "ring_gyro/ros/conversions.h"
#include "ros/bag_fixture.h"

namespace ring_gyro::test {
namespace {

using Estimates = std::vector<ring_gyro::ParameterEstimate>;

std::vector<std::uint8_t> bytesOf(const ring_gyro::ParameterEstimate& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

void expectSame(const Estimates& a, const Estimates& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(bytesOf(a[i]), bytesOf(b[i])) << "estimate " << i;
  }
}

struct Identified {
  Estimates estimates;
  bridge::IdentificationResult result;
};

class BagIdentificationTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    configuration_ = std::make_unique<cvg::LoopConfiguration>(
        cvg::readConfigurationFile(std::string(RING_GYRO_CONFIG_DIR) + "/paper_simulation.yaml",
                                   {"run/duration=4.05", "control/virtual_rate=1.0"}));
    live_ = recordRun(*configuration_, bag());
  }
  static void TearDownTestSuite() {
    configuration_.reset();
    folder_.reset();
  }

  static std::string bag() { return folder_->file("run.bag"); }
  static Identified identify(const std::vector<std::string>& bags,
                             const bridge::BagIdentificationOptions& options = {}) {
    Identified run;
    bridge::BagIdentification identification(bags, *configuration_, options);
    run.result = identification.run([&run](const cvg::ParameterEstimate& estimate) {
      run.estimates.emplace_back();
      bridge::toMessage(estimate, run.estimates.back());
    });
    return run;
  }

  static std::unique_ptr<TemporaryFolder> folder_;
  static std::unique_ptr<cvg::LoopConfiguration> configuration_;
  static Estimates live_;
};

std::unique_ptr<TemporaryFolder> BagIdentificationTest::folder_;
std::unique_ptr<cvg::LoopConfiguration> BagIdentificationTest::configuration_;
Estimates BagIdentificationTest::live_;

TEST_F(BagIdentificationTest, GivesTheBitsOfTheLiveRun) {
  const Identified run = identify({bag()});
  expectSame(run.estimates, live_);
  EXPECT_EQ(live_.size(), 40u);
  EXPECT_EQ(bridge::failureOf(run.result.report, *configuration_), "");
  EXPECT_TRUE(bridge::faultsOf(run.result.report, *configuration_).empty());
  EXPECT_EQ(run.result.report.pairs.pairs, 4050u);  // the tail after the last period too
  EXPECT_EQ(run.result.report.last.sequence, 4049u);
}

TEST_F(BagIdentificationTest, TopicsAreFoundByTheirTypes) {
  BagChange change;
  change.elements_topic = "/gyro/orbital_elements";
  change.gains_topic = "/gyro/control_gains";
  change.compression = rosbag::compression::BZ2;
  copyBag(bag(), folder_->file("renamed.bag"), change);
  expectSame(identify({folder_->file("renamed.bag")}).estimates, live_);
}

TEST_F(BagIdentificationTest, SplitBagsContinueAsOneRun) {
  const auto part = [](std::uint64_t from, std::uint64_t to) {
    BagChange change;
    change.elements = [=](auto& m) { return m.sequence >= from && m.sequence < to ? 1 : 0; };
    // A split falls between the two messages of a block.
    change.gains = [=](auto& m) { return m.sequence + 3 >= from && m.sequence + 3 < to ? 1 : 0; };
    return change;
  };
  copyBag(bag(), folder_->file("split_0.bag"), part(0, 1234));
  copyBag(bag(), folder_->file("split_1.bag"), part(1234, 2500));
  copyBag(bag(), folder_->file("split_2.bag"), part(2500, 9999));
  const Identified run = identify(
      {folder_->file("split_2.bag"), folder_->file("split_0.bag"), folder_->file("split_1.bag")});
  expectSame(run.estimates, live_);
  EXPECT_TRUE(bridge::faultsOf(run.result.report, *configuration_).empty());
}

TEST_F(BagIdentificationTest, StartSequenceIsAnIdentifierStartedThere) {
  cvg::Identifier identifier(configuration_->device, configuration_->identification,
                             configuration_->converter);
  Estimates expected;
  cvg::ClosedLoop loop(*configuration_);
  for (std::uint64_t i = 0; i < 4050; ++i) {
    const cvg::LoopRecord record = loop.step();
    if (i < 1537) continue;
    if (const auto estimate = identifier.process(record.loops.elements, record.loops.gains)) {
      expected.emplace_back();
      bridge::toMessage(*estimate, expected.back());
    }
  }
  bridge::BagIdentificationOptions options;
  options.start_sequence = 1537;
  const Identified run = identify({bag()}, options);
  expectSame(run.estimates, expected);
  EXPECT_EQ(run.result.report.before_start, 1537u);
}

TEST_F(BagIdentificationTest, StartAndDurationAreThoseOfTheBag) {
  bridge::BagIdentificationOptions options;
  options.start = 1.5;
  options.duration = 1.0;
  const Identified run = identify({bag()}, options);
  EXPECT_EQ(run.result.report.first.sequence, 1500u);
  EXPECT_EQ(run.result.report.last.sequence, 2500u);
  options.start = 5.0;
  EXPECT_THROW(identify({bag()}, options), bridge::BagError);
}

TEST_F(BagIdentificationTest, LostMessagesAreCounted) {
  BagChange change;
  change.elements = [](auto& m) { return m.sequence >= 2010 && m.sequence < 2020 ? 0 : 1; };
  change.gains = [](auto& m) { return m.sequence == 3333 ? 0 : 1; };
  copyBag(bag(), folder_->file("gaps.bag"), change);
  const Identified run = identify({folder_->file("gaps.bag")});
  EXPECT_EQ(run.result.report.elements.lost, 10u);
  EXPECT_EQ(run.result.report.gains.lost, 1u);
  EXPECT_EQ(run.result.report.pairs.gains_alone, 10u);
  EXPECT_EQ(run.result.report.pairs.elements_alone, 1u);
  EXPECT_EQ(run.estimates.back().lost_blocks, 11u);
  EXPECT_EQ(bridge::failureOf(run.result.report, *configuration_), "");
}

TEST_F(BagIdentificationTest, CutOffBagIsIdentifiedAsFarAsItGoes) {
  copyBag(bag(), folder_->file("whole.bag"), {});
  const std::string bytes = contentsOf(folder_->file("whole.bag"));
  writeContents(folder_->file("cut.bag"), bytes.substr(0, bytes.size() * 2 / 3));
  const Identified run = identify({folder_->file("cut.bag")});
  ASSERT_EQ(run.result.damage.size(), 1u);
  ASSERT_GT(run.estimates.size(), 15u);
  ASSERT_LT(run.estimates.size(), live_.size());
  expectSame(run.estimates,
             {live_.begin(), live_.begin() + static_cast<long>(run.estimates.size())});
}

TEST_F(BagIdentificationTest, DamagedChunkIsPassedOver) {
  copyBag(bag(), folder_->file("whole.bag"), {});
  const std::string whole = contentsOf(folder_->file("whole.bag"));
  const std::size_t chunk = whole.find("compression=lz4", whole.size() / 2);
  // In its data: the index still leads to the others. In its header: what follows must be searched.
  for (const std::size_t where : {chunk + 2000, chunk}) {
    std::string bytes = whole;
    bytes.replace(where, 2000, 2000, '\x55');
    writeContents(folder_->file("damaged.bag"), bytes);
    const Identified run = identify({folder_->file("damaged.bag")});
    ASSERT_EQ(run.result.damage.size(), 1u);
    EXPECT_GT(run.result.report.elements.lost, 0u) << run.result.damage.front();
    EXPECT_EQ(run.result.report.last.sequence, 4049u) << run.result.damage.front();
    EXPECT_EQ(bridge::failureOf(run.result.report, *configuration_), "");
  }
}

TEST_F(BagIdentificationTest, JsonHasAllNumbersToTheLastBit) {
  const Identified run = identify({bag()});
  const auto json =
      nlohmann::json::parse(bridge::identificationJson({run.result}, *configuration_));
  const auto& object = json.at("runs").at(0);
  EXPECT_TRUE(object.at("identified").get<bool>());
  EXPECT_EQ(object.at("parameters").at("ks").at("value").get<double>(),
            live_.back().value[cvg::kDriveGain]);
  const std::pair<const char*, cvg::StateIndex> sigmas[] = {
      {"a", cvg::kA}, {"b", cvg::kB}, {"gamma2", cvg::kGamma2}, {"ks", cvg::kDriveGain}};
  for (const auto& [name, state] : sigmas) {
    EXPECT_EQ(object.at("parameters").at(name).at("sigma").get<double>(), live_.back().sigma[state])
        << name;
    EXPECT_GT(live_.back().sigma[state], 0.0) << name;
  }
  EXPECT_EQ(object.at("covariance").at(3).at(5).get<double>(), live_.back().covariance[7 * 3 + 5]);
  EXPECT_EQ(object.at("counts").at("used").get<std::uint64_t>(), live_.back().used_blocks);
  EXPECT_EQ(object.at("settings").at("device").at("quality_factor").get<double>(), 22000.0);
  EXPECT_FALSE(json.at("version").get<std::string>().empty());
}

TEST(NisBounds, AreThoseOfTheTables) {
  // Chi-squared with 2 and with 100 degrees of freedom.
  EXPECT_NEAR(cvg::nisBounds(1).lower, 0.050636, 1e-5);
  EXPECT_NEAR(cvg::nisBounds(1).upper, 7.377759, 1e-5);
  EXPECT_NEAR(cvg::nisBounds(50).lower, 74.2219 / 50.0, 1e-5);
  EXPECT_NEAR(cvg::nisBounds(50).upper, 129.5612 / 50.0, 1e-5);
}

}  // namespace
}  // namespace ring_gyro::test
