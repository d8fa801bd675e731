#include "ring_gyro/configuration/configuration_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "ring_gyro/configuration/parameter_text.h"

namespace cvg {
namespace {

const char* const kMinimal =
    "device: {natural_frequency: 14.0e3, quality_factor: 22000, drive_gain: 1.1e+5}\n"
    "resonator: {natural_frequency: 14.0e3, quality_factor: 22000, drive_gain: 1.1e+5}\n";

YAML::Node minimal() { return YAML::Load(kMinimal); }

std::vector<std::string> faultsOf(const YAML::Node& root) {
  try {
    readConfiguration(root);
  } catch (const ConfigurationError& error) {
    return error.faults();
  }
  return {};
}

/// The only fault of the minimal configuration with one value changed.
std::string faultOf(const std::string& section, const std::string& key, const std::string& value) {
  YAML::Node root = minimal();
  root[section][key] = YAML::Load(value);
  const std::vector<std::string> faults = faultsOf(root);
  EXPECT_EQ(faults.size(), 1u);
  return faults.empty() ? "" : faults.front();
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ConfigurationReader, DefaultsStay) {
  const LoopConfiguration configuration = readConfiguration(minimal());
  EXPECT_EQ(configuration.run.seed, 1);
  EXPECT_EQ(configuration.converter.block_samples, 200);
  EXPECT_EQ(configuration.device.natural_frequency, 14e3);
  EXPECT_EQ(configuration.device.quality_factor, 22000.0);
  EXPECT_EQ(configuration.device.drive_gain, 1.1e5);
  EXPECT_EQ(configuration.device.angular_gain, 1.0);
}

TEST(ConfigurationReader, TakesEveryTextThatIsWhollyANumber) {
  YAML::Node root = minimal();
  for (const char* text : {"2e-1", "0.2", "+.2", "\"0.2\"", "2.0E-1"}) {
    root["control"]["virtual_rate"] = YAML::Load(text);
    EXPECT_EQ(readConfiguration(root).control.virtual_rate, 0.2) << text;
  }
  root["control"]["virtual_rate"] = YAML::Load("-3");
  EXPECT_EQ(readConfiguration(root).control.virtual_rate, -3.0);
  root["run"]["seed"] = YAML::Load("1e3");
  EXPECT_EQ(readConfiguration(root).run.seed, 1000);
  root["control"]["compensation"] = YAML::Load("True");
  EXPECT_TRUE(readConfiguration(root).control.compensation);
}

TEST(ConfigurationReader, TakesTextThatIsANumberWithinListsToo) {
  YAML::Node root = minimal();
  root["calibration"]["drift_cosine"] = YAML::Load("[0, '1e-07', \"-2.5e-3\", 4e-1]");
  EXPECT_EQ(readConfiguration(root).corrections.drift.cosine,
            (std::vector<double>{0.0, 1e-7, -2.5e-3, 0.4}));
}

TEST(ConfigurationReader, NamesWhatIsMissing) {
  YAML::Node root = minimal();
  root["device"].remove("drive_gain");
  const auto faults = faultsOf(root);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(contains(faults[0], "device/drive_gain: missing")) << faults[0];
  EXPECT_TRUE(contains(faults[0], "> 0 [1/s^2]")) << faults[0];
}

TEST(ConfigurationReader, NamesUnknownKeysAndTheNearest) {
  const std::string fault = faultOf("control", "virtul_rate", "0.2");
  EXPECT_TRUE(contains(fault, "control/virtul_rate = 0.2: unknown")) << fault;
  EXPECT_TRUE(contains(fault, "did you mean control/virtual_rate?")) << fault;
  const std::string elsewhere = faultOf("control", "gamma1", "0.1");
  EXPECT_TRUE(contains(elsewhere, "did you mean resonator/gamma1?")) << elsewhere;
}

TEST(ConfigurationReader, NamesUnknownSectionsAndTheNearest) {
  const std::string fault = faultOf("controll", "virtual_rate", "0.2");
  EXPECT_TRUE(contains(fault, "controll = ")) << fault;
  EXPECT_TRUE(contains(fault, "did you mean control?")) << fault;
}

TEST(ConfigurationReader, NamesWrongTypes) {
  for (const char* value : {"fast", "0.2 rad/s", "\"\"", "1e", "0x10", "true"}) {
    const std::string fault = faultOf("control", "virtual_rate", value);
    EXPECT_TRUE(contains(fault, "control/virtual_rate = ")) << fault;
    EXPECT_TRUE(contains(fault, "not a number; allowed: [-100, 100] [rad/s]")) << fault;
  }
  EXPECT_TRUE(contains(faultOf("control", "virtual_rate", "[1, 2]"), "not a single value"));
  EXPECT_TRUE(contains(faultOf("control", "virtual_rate", "~"), "(nothing)"));
  EXPECT_TRUE(contains(faultOf("run", "seed", "1.5"), "run/seed = 1.5: not a whole number"));
  EXPECT_TRUE(contains(faultOf("run", "seed", "many"), "not a whole number"));
  EXPECT_TRUE(contains(faultOf("control", "compensation", "1"), "not true or false"));
}

TEST(ConfigurationReader, NamesValuesThatAreNotFinite) {
  for (const char* value : {".nan", "nan", ".inf", "-.inf", "1e999"}) {
    const std::string fault = faultOf("control", "virtual_rate", value);
    EXPECT_TRUE(contains(fault, "not finite")) << value << ": " << fault;
  }
  EXPECT_TRUE(contains(faultOf("run", "seed", ".nan"), "not finite"));
}

TEST(ConfigurationReader, NamesValuesOutOfRange) {
  const std::string fault = faultOf("device", "quality_factor", "-22000");
  EXPECT_TRUE(contains(fault, "device/quality_factor = -22000: out of range; allowed: [10,"))
      << fault;
  EXPECT_TRUE(contains(faultOf("run", "seed", "1e300"), "out of range"));
}

TEST(ConfigurationReader, NamesTheChoices) {
  const std::string fault = faultOf("rotation", "profile", "wobble");
  EXPECT_TRUE(contains(fault, "rotation/profile = wobble: unknown choice; allowed: one of: "))
      << fault;
  EXPECT_TRUE(contains(fault, "sine")) << fault;
}

TEST(ConfigurationReader, NamesWhatIsGivenTwice) {
  const YAML::Node root =
      YAML::Load(std::string(kMinimal) + "run: {seed: 1, seed: 2}\nrun: {duration: 1.0}\n");
  const auto faults = faultsOf(root);
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_TRUE(contains(faults[0], "run/seed = 2: given twice")) << faults[0];
  EXPECT_TRUE(contains(faults[1], "run: section given twice")) << faults[1];
}

TEST(ConfigurationReader, CollectsAllFaultsOneOnALine) {
  YAML::Node root = minimal();
  root["device"].remove("drive_gain");
  root["control"]["virtual_rate"] = "fast\nfaster";
  root["control"]["virtul_rate"] = 1.0;
  root["run"]["seed"] = -1;
  root["noise"] = 3;
  try {
    readConfiguration(root);
    FAIL() << "accepted";
  } catch (const ConfigurationError& error) {
    EXPECT_EQ(error.faults().size(), 5u);
    const std::string text = error.what();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  }
}

TEST(ConfigurationReader, ChecksTheNodeSectionWithoutNeedingIt) {
  YAML::Node root = minimal();
  root["node"]["lockstep"] = false;
  NodeParameters node;
  readConfiguration(root, &node);
  EXPECT_FALSE(node.lockstep);
  EXPECT_NO_THROW(readConfiguration(root));
  root["node"]["lockstepp"] = false;
  EXPECT_EQ(faultsOf(root).size(), 1u);
}

TEST(ConfigurationReader, ReadsFilesWithOverrides) {
  const std::string path = ::testing::TempDir() + "ring_gyro_configuration_reader_test.yaml";
  std::ofstream(path) << kMinimal;
  const auto configuration =
      readConfigurationFile(path, {"control/virtual_rate=0.2", "run/duration=3"});
  EXPECT_EQ(configuration.control.virtual_rate, 0.2);
  EXPECT_EQ(configuration.run.duration, 3.0);
  try {
    readConfigurationFile(path, {"virtual_rate=0.2", "run/duration=long"});
    FAIL() << "accepted";
  } catch (const ConfigurationError& error) {
    ASSERT_EQ(error.faults().size(), 2u);
    EXPECT_TRUE(contains(error.faults()[0], "not of the form section/key=value"));
    EXPECT_TRUE(contains(error.faults()[1], "run/duration = long: not a number"));
  }
  std::ofstream(path) << "run: [1, 2\n";
  EXPECT_THROW(readConfigurationFile(path), ConfigurationError);
  std::remove(path.c_str());
  EXPECT_THROW(readConfigurationFile(path), ConfigurationError);
}

TEST(ConfigurationReader, ReadsThePresets) {
  for (const char* preset : {"paper_simulation", "paper_experiment"}) {
    const std::string path = std::string(RING_GYRO_CONFIG_DIR "/") + preset + ".yaml";
    const LoopConfiguration configuration = readConfigurationFile(path);
    EXPECT_NEAR(configuration.control.virtual_rate, 12.0 * kPi / 180.0, 1e-8) << preset;
    EXPECT_EQ(configuration.control.frequency_offset, 5.0) << preset;
  }
}

TEST(ParameterText, TakesTheNumbersOfYamlThatAreNone) {
  for (const char* text : {".nan", "nan", ".NaN"}) EXPECT_TRUE(std::isnan(*numberFromText(text)));
  for (const char* text : {".inf", "+.inf", "inf", "1e400"}) {
    EXPECT_EQ(*numberFromText(text), std::numeric_limits<double>::infinity()) << text;
  }
  EXPECT_EQ(*numberFromText("-.Inf"), -std::numeric_limits<double>::infinity());
  for (const char* text : {".", "..inf", ".in", "-", "1.inf"})
    EXPECT_FALSE(numberFromText(text)) << text;
}

TEST(ParametersMarkdown, IsThePageInDocs) {
  std::ifstream file(RING_GYRO_CONFIG_DIR "/../docs/parameters.md");
  std::ostringstream page;
  page << file.rdbuf();
  EXPECT_TRUE(page.str() == parametersMarkdown())
      << "docs/parameters.md is out of date: simulate --parameters > docs/parameters.md";
}

TEST(ParametersMarkdown, HasEveryParameter) {
  const std::string page = parametersMarkdown();
  LoopConfiguration configuration;
  for (const Section& section : configuration.sections()) {
    EXPECT_TRUE(contains(page, "## " + section.name + "\n")) << section.name;
    for (const Parameter& parameter : section.table.parameters()) {
      EXPECT_TRUE(contains(page, "| `" + parameter.key + "` |")) << parameter.key;
    }
  }
}

}  // namespace
}  // namespace cvg
