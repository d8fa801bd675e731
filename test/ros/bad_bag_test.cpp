// Bags that are not as they should be: the tools say so in one line that names the file, what is
// wrong and the mend, and their exit status tells. What can be identified is.

#include <gtest/gtest.h>
#include <std_msgs/String.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "ros/bag_fixture.h"

namespace ring_gyro::test {
namespace {

struct Outcome {
  int exit_code = -1;
  std::string errors;  // standard error
  std::string output;

  long lines() const { return std::count(errors.begin(), errors.end(), '\n'); }
};

class BadBagTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    recordRun(cvg::readConfigurationFile(configuration(),
                                         {"run/duration=3.05", "control/virtual_rate=1.0"}),
              good());
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string configuration() {
    return std::string(RING_GYRO_CONFIG_DIR) + "/paper_simulation.yaml";
  }
  static std::string good() { return folder_->file("good.bag"); }
  static std::string json() { return folder_->file("result.json"); }

  /// A changed copy of the good bag.
  static std::string changed(const std::string& name, const BagChange& change) {
    copyBag(good(), folder_->file(name), change);
    return folder_->file(name);
  }

  static Outcome run(const std::string& command) {
    const std::string errors = folder_->file("stderr");
    const std::string output = folder_->file("stdout");
    const int status = std::system(
        (std::string(RING_GYRO_NODE_DIR) + "/" + command + " >" + output + " 2>" + errors).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contentsOf(errors), contentsOf(output)};
  }
  static Outcome identify(const std::string& bag, const std::string& more = "") {
    std::remove(json().c_str());
    return run("identify " + bag + " --config " + configuration() + " --json " + json() + " " +
               more);
  }
  static Outcome validate(const std::string& bag) { return run("validate_bag " + bag); }

  /// One line with the file, what is wrong and the mend; no result.
  static void expectRefused(const std::string& bag, const std::string& what,
                            const std::string& mend) {
    const Outcome outcome = identify(bag);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.lines(), 1) << outcome.errors;
    for (const std::string& part : {bag, what, mend}) {
      EXPECT_NE(outcome.errors.find(part), std::string::npos) << part << " in " << outcome.errors;
    }
    EXPECT_EQ(outcome.output.find("gamma1"), std::string::npos);
    EXPECT_EQ(validate(bag).exit_code, 2);
  }
  /// Parameters came out, and a line says what was wrong with the data.
  static nlohmann::json expectIdentifiedWithFault(const std::string& bag, const std::string& what,
                                                  int validate_status) {
    const Outcome outcome = identify(bag);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_NE(outcome.errors.find(bag + ": "), std::string::npos) << outcome.errors;
    EXPECT_NE(outcome.errors.find(what), std::string::npos) << outcome.errors;
    EXPECT_NE(outcome.output.find("gamma1"), std::string::npos);
    const Outcome validation = validate(bag);
    EXPECT_EQ(validation.exit_code, validate_status) << validation.output;
    const auto result = nlohmann::json::parse(contentsOf(json()));
    EXPECT_TRUE(result.at("runs").at(0).at("identified").get<bool>());
    return result.at("runs").at(0);
  }

  static std::unique_ptr<TemporaryFolder> folder_;
};

std::unique_ptr<TemporaryFolder> BadBagTest::folder_;

TEST_F(BadBagTest, GoodBagIsFine) {
  const Outcome outcome = identify(good());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  EXPECT_TRUE(exists(json()));
  const Outcome validation = validate(good());
  EXPECT_EQ(validation.exit_code, 0) << validation.output;
}

TEST_F(BadBagTest, Missing) {
  expectRefused(folder_->file("nowhere.bag"), "No such file", "check the path");
}

TEST_F(BadBagTest, EmptyFile) {
  writeContents(folder_->file("empty.bag"), "");
  expectRefused(folder_->file("empty.bag"), "empty", "record again");
}

TEST_F(BadBagTest, NotABag) {
  writeContents(folder_->file("log.bag"), "t,a,b,theta\n0,1,0,0\n");
  expectRefused(folder_->file("log.bag"), "not a bag", "import_csv");
}

TEST_F(BadBagTest, WithoutMessages) {
  rosbag::Bag(folder_->file("none.bag"), rosbag::bagmode::Write).close();
  expectRefused(folder_->file("none.bag"), "no messages", "record");
}

TEST_F(BadBagTest, Truncated) {
  const std::string whole = changed("whole.bag", {});
  const std::string bytes = contentsOf(whole);
  const std::string cut = folder_->file("cut.bag");
  writeContents(cut, bytes.substr(0, bytes.size() * 3 / 4));
  const auto result = expectIdentifiedWithFault(cut, "lost", 2);
  EXPECT_EQ(result.at("damage").size(), 1u);
  EXPECT_LT(result.at("data").at("last_sequence").get<int>(), 3049);

  writeContents(cut, bytes.substr(0, 5000));
  expectRefused(cut, "cut off", "nothing can be saved");
}

TEST_F(BadBagTest, Unindexed) {
  // As a recorder leaves it that was killed: the place of the index is still zero.
  std::string bytes = contentsOf(changed("indexed.bag", {}));
  const std::string field = "index_pos=";
  bytes.replace(bytes.find(field) + field.size(), 8, 8, '\0');
  const std::string bag = folder_->file("unindexed.bag");
  writeContents(bag, bytes);
  const auto result = expectIdentifiedWithFault(bag, "rosbag reindex", 2);
  EXPECT_EQ(result.at("data").at("last_sequence").get<int>(), 3049);
}

TEST_F(BadBagTest, ToolsThatNeedAWholeBagRefuseAnother) {
  const std::string whole = contentsOf(changed("whole.bag", {}));
  std::string damaged = whole;
  damaged.replace(whole.find("compression=lz4", whole.size() / 2) + 2000, 2000, 2000, '\x55');
  for (const std::string& bytes : {whole.substr(0, whole.size() * 3 / 4), damaged}) {
    const std::string bag = folder_->file("part.bag");
    writeContents(bag, bytes);
    for (const std::string& command :
         {"summarise_run " + bag, "export_csv " + bag + " --output " + folder_->file("log.csv")}) {
      const Outcome outcome = run(command);
      EXPECT_EQ(outcome.exit_code, 1) << command;
      EXPECT_EQ(outcome.lines(), 1) << outcome.errors;
      for (const std::string& part : {bag, std::string("lost"), std::string("rosbag reindex")}) {
        EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
      }
      EXPECT_EQ(outcome.output, "");
    }
    EXPECT_FALSE(exists(folder_->file("log.csv")));
    // This one goes on with what is left, and says so.
    const Outcome outcome = run("compare_identifiers " + bag + " --config " + configuration());
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.errors.find(bag + ": cut off or damaged"), std::string::npos);
    EXPECT_NE(outcome.output.find("extended filter"), std::string::npos);
  }
}

TEST_F(BadBagTest, Encrypted) {
  const auto field = [](const std::string& text) {
    const auto size = static_cast<std::uint32_t>(text.size());
    return std::string(reinterpret_cast<const char*>(&size), 4) + text;
  };
  const std::string header = field("chunk_count=" + std::string(4, '\0')) +
                             field("conn_count=" + std::string(4, '\0')) +
                             field("encryptor=rosbag/AesCbcEncryptor") +
                             field("index_pos=" + std::string(1, '\x40') + std::string(7, '\0')) +
                             field(std::string("op=\x03"));
  writeContents(folder_->file("secret.bag"),
                "#ROSBAG V2.0\n" + field(header) + field(std::string(4096, ' ')));
  expectRefused(folder_->file("secret.bag"), "encrypted by rosbag/AesCbcEncryptor",
                "rosbag decrypt");
}

TEST_F(BadBagTest, MissingTopic) {
  BagChange change;
  change.gains = [](auto&) { return 0; };
  expectRefused(changed("elements_only.bag", change), "no topic of type ring_gyro/ControlGains",
                "record orbital_elements and control_gains");
}

TEST_F(BadBagTest, WrongType) {
  BagChange change;
  change.gains = [](auto&) { return 0; };
  const std::string bag = changed("wrong_type.bag", change);
  rosbag::Bag(bag, rosbag::bagmode::Append)
      .write("/control_gains", ros::Time(2.0), std_msgs::String());
  expectRefused(bag, "topic /control_gains is a std_msgs/String", "record the topic");
}

TEST_F(BadBagTest, WrongMd5) {
  BagChange change;
  change.compression = rosbag::compression::Uncompressed;
  std::string bytes = contentsOf(changed("plain.bag", change));
  const std::string md5 = ros::message_traits::md5sum<ring_gyro::ControlGains>();
  for (std::size_t at = bytes.find(md5); at != std::string::npos; at = bytes.find(md5, at)) {
    bytes.replace(at, md5.size(), std::string(md5.size(), 'e'));
  }
  writeContents(folder_->file("old.bag"), bytes);
  expectRefused(folder_->file("old.bag"), "of another version of this package", "rosbag fix");
}

TEST_F(BadBagTest, TwoTopics) {
  BagChange change;
  change.elements_topic = "/second/orbital_elements";
  const std::string bag = changed("two.bag", change);
  ring_gyro::OrbitalElements message;
  rosbag::Bag(bag, rosbag::bagmode::Append)
      .write("/first/orbital_elements", ros::Time(2.0), message);
  expectRefused(bag, "two topics", "--elements");
  EXPECT_EQ(identify(bag, "--elements /second/orbital_elements").exit_code, 0);
}

TEST_F(BadBagTest, NotFinite) {
  BagChange change;
  change.elements = [](auto& m) {
    if (m.sequence == 2000) m.a = std::numeric_limits<double>::quiet_NaN();
    return 1;
  };
  const auto result = expectIdentifiedWithFault(changed("nan.bag", change), "not finite", 2);
  EXPECT_EQ(result.at("counts").at("unusable").at("not_finite").get<int>(), 1);
  change.elements = [](auto& m) {
    m.theta = std::numeric_limits<double>::infinity();
    return 1;
  };
  expectRefused(changed("all_nan.bag", change), "not finite", "check what recorded");
}

TEST_F(BadBagTest, OnlyTheTotalDriveIsEnough) {
  BagChange change;
  change.gains = [](auto& m) {
    m.sustain = m.quadrature = m.steering = m.compensation = {};
    return 1;
  };
  const Outcome outcome = identify(changed("total.bag", change));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto total = nlohmann::json::parse(contentsOf(json())).at("runs").at(0);
  EXPECT_EQ(identify(good()).exit_code, 0);
  const auto parts = nlohmann::json::parse(contentsOf(json())).at("runs").at(0);
  EXPECT_EQ(total.at("counts"), parts.at("counts"));
  for (const char* name : {"gamma1", "mu2", "ks"}) {
    const auto& with_total = total.at("parameters").at(name);
    const auto& with_parts = parts.at("parameters").at(name);
    const double sigma = with_parts.at("sigma").get<double>();
    EXPECT_NEAR(with_total.at("value").get<double>(), with_parts.at("value").get<double>(),
                1e-6 * sigma)
        << name;
  }
}

TEST_F(BadBagTest, DriveThatContradictsItsParts) {
  BagChange change;
  change.gains = [](auto& m) {
    if (m.sequence == 2000) m.drive.y_imag += 0.01;
    return 1;
  };
  const auto result =
      expectIdentifiedWithFault(changed("one_drive.bag", change), "is not the sum of its parts", 2);
  EXPECT_EQ(result.at("counts").at("unusable").at("contradiction").get<int>(), 1);
  change.gains = [](auto& m) {
    m.drive = {};
    return 1;
  };
  expectRefused(changed("all_drives.bag", change), "whose drive contradicts its parts",
                "is not the sum of its parts");
}

TEST_F(BadBagTest, ZeroFrequencyIsNotUsable) {
  BagChange change;
  change.gains = [](auto& m) {
    if (m.sequence >= 2000 && m.sequence < 2010) m.reference_frequency = 0.0;
    return 1;
  };
  const auto result = expectIdentifiedWithFault(changed("frequency.bag", change),
                                                "without a reference frequency", 2);
  EXPECT_EQ(result.at("counts").at("unusable").at("no_frequency").get<int>(), 10);
  change.gains = [](auto& m) {
    m.reference_frequency = 0.0;
    return 1;
  };
  expectRefused(changed("no_frequency.bag", change), "without a reference frequency",
                "check what recorded the reference frequency");
}

TEST_F(BadBagTest, ImpossibleNumbers) {
  BagChange change;
  change.elements = [](auto& m) {
    if (m.sequence == 2000) m.group_delay = -0.001;
    return 1;
  };
  auto result = expectIdentifiedWithFault(changed("delay.bag", change), "group_delay = -0.001", 2);
  EXPECT_EQ(result.at("counts").at("unusable").at("impossible").get<int>(), 1);
  change = {};
  change.gains = [](auto& m) {
    if (m.sequence == 2000) m.beta = std::numeric_limits<double>::quiet_NaN();
    return 1;
  };
  result = expectIdentifiedWithFault(changed("beta_nan.bag", change), "beta = nan", 2);
  EXPECT_EQ(result.at("counts").at("unusable").at("not_finite").get<int>(), 1);
}

TEST_F(BadBagTest, AHopelessFitIsNotConverged) {
  EXPECT_NE(identify(good(),
                     "--set identification/converged_mu_sigma=1 "
                     "--set identification/converged_angle=1")
                .output.find("converged    after"),
            std::string::npos);
  // Half the drive along x had never acted: no set of parameters makes such a motion.
  BagChange change;
  change.gains = [](auto& m) {
    for (auto* envelope : {&m.drive, &m.sustain, &m.quadrature, &m.steering, &m.compensation}) {
      envelope->x_real *= 0.5;
      envelope->x_imag *= 0.5;
    }
    return 1;
  };
  const std::string bag = changed("hopeless.bag", change);
  Outcome outcome = identify(bag,
                             "--set identification/converged_mu_sigma=1 "
                             "--set identification/converged_angle=1");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_EQ(outcome.lines(), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find(bag + ": the data do not fit the model: mean NIS"),
            std::string::npos)
      << outcome.errors;
  EXPECT_EQ(outcome.output.find("converged    after"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("converged    no: "), std::string::npos) << outcome.output;
  const auto result = nlohmann::json::parse(contentsOf(json())).at("runs").at(0);
  EXPECT_FALSE(result.at("converged").get<bool>());
  EXPECT_EQ(result.at("faults").size(), 1u);
  outcome = identify(bag, "--extended");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find(bag + ": extended: the data do not fit"), std::string::npos)
      << outcome.errors << outcome.output;
}

TEST_F(BadBagTest, ASecondPlantIsLeftOutOnceItIsLeft) {
  // Two plants at once: each block of the bag, and after it a block of another session.
  const std::string bag = folder_->file("two_plants.bag");
  {
    const rosbag::Bag from(good());
    rosbag::Bag to(bag, rosbag::bagmode::Write);
    rosbag::View view(from);
    for (const rosbag::MessageInstance& instance : view) {
      const auto write_both = [&](auto message, const char* topic) {
        if (!message) return;
        if (message->sequence < 1000) {
          auto other = *message;
          other.session += 1;
          to.write(topic, instance.getTime(), other);
        }
        to.write(topic, instance.getTime(), *message);
      };
      write_both(instance.instantiate<ring_gyro::OrbitalElements>(),
                 bridge::topics::kOrbitalElements);
      write_both(instance.instantiate<ring_gyro::ControlGains>(), bridge::topics::kControlGains);
    }
  }
  const auto result =
      expectIdentifiedWithFault(bag, "of a session that had been left, left out", 2);
  EXPECT_EQ(result.at("counts").at("new_sessions").get<int>(), 1);
  EXPECT_EQ(result.at("counts").at("filter_restarts").get<int>(), 1);
  EXPECT_EQ(result.at("counts").at("left_sessions").get<int>(), 2 * 999);
  EXPECT_EQ(result.at("data").at("last_sequence").get<int>(), 3049);
}

TEST_F(BadBagTest, ConstantTheta) {
  BagChange change;
  change.elements = [](auto& m) {
    m.theta = 0.7;
    return 1;
  };
  expectRefused(changed("constant.bag", change), "theta stands still", "steer the pattern");
}

TEST_F(BadBagTest, AllZero) {
  BagChange change;
  change.elements = [](auto& m) {
    m.a = m.b = m.theta = m.phi = m.theta_rate = m.group_delay = 0.0;
    return 1;
  };
  change.gains = [](auto& m) {
    m.drive = m.sustain = m.quadrature = m.steering = m.compensation = {};
    m.beta = m.alpha = m.reference_frequency = 0.0;
    return 1;
  };
  expectRefused(changed("zero.bag", change), "without amplitude", "check what recorded");
}

TEST_F(BadBagTest, ZeroStamps) {
  BagChange change;
  change.elements = [](auto& m) {
    if (m.sequence == 1000) m.header.stamp = ros::Time();
    return 1;
  };
  const auto result = expectIdentifiedWithFault(changed("zero.bag", change), "zero stamps", 2);
  EXPECT_EQ(result.at("counts").at("zero_stamps").get<int>(), 1);
  change.elements = [](auto& m) {
    m.header.stamp = ros::Time();
    return 1;
  };
  expectRefused(changed("all_zero.bag", change), "every stamp is zero", "header.stamp");
}

TEST_F(BadBagTest, DuplicateStamps) {
  BagChange change;
  change.gains = [](auto& m) { return m.sequence % 100 == 50 ? 2 : 1; };
  const auto result = expectIdentifiedWithFault(changed("twice.bag", change), "duplicate", 1);
  EXPECT_EQ(result.at("counts").at("duplicates").get<int>(), 30);
  EXPECT_EQ(result.at("data").at("last_sequence").get<int>(), 3049);
}

TEST_F(BadBagTest, StampsThatStepBack) {
  // The bag played twice, one after the other.
  BagChange change;
  const auto back = [](auto& m) {
    if (m.sequence >= 2000) {
      m.sequence -= 2000;
      m.header.stamp -= ros::Duration(2.0);
    }
    return 1;
  };
  change.elements = back;
  change.gains = back;
  const auto result = expectIdentifiedWithFault(changed("back.bag", change), "steps back", 2);
  EXPECT_EQ(result.at("counts").at("filter_restarts").get<int>(), 1);
  EXPECT_GT(result.at("counts").at("out_of_order").get<int>(), 0);
}

TEST_F(BadBagTest, OtherDevice) {
  const Outcome outcome = identify(good(), "--set device/natural_frequency=15e3");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("device/natural_frequency is 15000 Hz"), std::string::npos);
  const Outcome blocks = identify(good(), "--set converter/block_samples=400");
  EXPECT_EQ(blocks.exit_code, 1);
  EXPECT_NE(blocks.errors.find("converter/block_samples"), std::string::npos) << blocks.errors;
}

TEST_F(BadBagTest, ImpossibleUnits) {
  BagChange change;
  change.elements = [](auto& m) {
    m.a *= 1e4;
    return 1;
  };
  Outcome outcome = validate(changed("counts.bag", change));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("a above 1000 V"), std::string::npos) << outcome.output;
  change = {};
  change.gains = [](auto& m) {
    m.beta = -m.beta;
    return 1;
  };
  outcome = validate(changed("beta.bag", change));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("beta has the wrong sign"), std::string::npos) << outcome.output;
  change = {};
  change.elements = [](auto& m) {
    m.phi *= 57.29578;
    return 1;
  };
  outcome = validate(changed("degrees.bag", change));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("degrees"), std::string::npos) << outcome.output;
}

TEST_F(BadBagTest, GapsAreWarningsOfTheValidation) {
  BagChange change;
  const auto gap = [](auto& m) { return m.sequence >= 1500 && m.sequence < 1520 ? 0 : 1; };
  change.elements = gap;
  change.gains = gap;
  const auto result = expectIdentifiedWithFault(changed("gap.bag", change), "missing in gaps", 1);
  EXPECT_EQ(result.at("counts").at("gaps").get<int>(), 20);
}

TEST_F(BadBagTest, OneBadBagDoesNotStopTheOthers) {
  const Outcome outcome = identify(good() + " " + folder_->file("nowhere.bag") + " " + good());
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.lines(), 1) << outcome.errors;
  EXPECT_EQ(nlohmann::json::parse(contentsOf(json())).at("runs").size(), 2u);
}

TEST_F(BadBagTest, OutputIsWholeOrNotThere) {
  const Outcome outcome =
      run("identify " + good() + " --config " + configuration() + " --json /nowhere/at/all.json");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.errors.find("/nowhere/at/all.json: cannot be written"), std::string::npos);
  const Outcome missing = run("identify " + good());
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_EQ(missing.lines(), 1);
  EXPECT_NE(missing.errors.find("--config"), std::string::npos);
  EXPECT_FALSE(exists(json() + ".part"));
}

}  // namespace
}  // namespace ring_gyro::test
