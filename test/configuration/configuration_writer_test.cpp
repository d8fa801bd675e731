// What one program writes the others read: the same values to the last bit, or nothing is written.

#include "ring_gyro/configuration/configuration_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <regex>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"

namespace cvg {
namespace {

using Random = std::mt19937_64;

/// Anywhere in the range, at an end of it, or as close to zero as a number can be.
double valueIn(const Range& range, Random& random) {
  const double lowest = std::max(range.lowest, -1e18);
  const double highest = std::min(range.highest, 1e18);
  const auto share = [&random] { return std::uniform_real_distribution<double>()(random); };
  double value = 0.0;
  switch (random() % 6) {
    case 0:
      value = highest;
      break;
    case 1:
      value = range.lowest_excluded ? std::nextafter(lowest, highest) : lowest;
      break;
    case 2:
      value = std::ldexp(highest, -static_cast<int>(random() % 1100));
      break;
    case 3:
      value = std::round(highest * share());
      break;
    default:
      value = lowest + share() * (highest - lowest);
  }
  return range.contains(value) ? value : 0.5 * lowest + 0.5 * highest;
}

void fill(const Section& section, Random& random) {
  for (const Parameter& parameter : section.table.parameters()) {
    if (auto* const* number = std::get_if<double*>(&parameter.target)) {
      **number = valueIn(parameter.range, random);
    } else if (auto* const* list = std::get_if<std::vector<double>*>(&parameter.target)) {
      (*list)->resize(random() % 9);
      for (double& value : **list) value = valueIn(parameter.range, random);
    } else if (auto* const* flag = std::get_if<bool*>(&parameter.target)) {
      **flag = random() % 2 == 0;
    }
  }
}

struct Device {
  DeviceKnowledge device;
  Corrections corrections;

  Sections sections() {
    Sections result = {{"device", {}}, {"calibration", {}}};
    device.declare(result[0].table);
    corrections.declare(result[1].table);
    return result;
  }
};

CalibrationResult resultOf(const Device& found) {
  CalibrationResult result;
  result.corrections = found.corrections;
  result.device = found.device;
  result.angle_map_measured = true;
  return result;
}

LoopConfiguration read(const std::string& yaml) {
  YAML::Node root = YAML::Load(
      "resonator: {natural_frequency: 14.0e3, quality_factor: 22000, drive_gain: 1.1e+5}\n" + yaml);
  return readConfiguration(root);
}

void expectSame(Sections written, Sections back) {
  for (std::size_t s = 0; s < written.size(); ++s) {
    for (std::size_t k = 0; k < written[s].table.parameters().size(); ++k) {
      const Parameter& one = written[s].table.parameters()[k];
      const Parameter& other = back[s].table.parameters()[k];
      std::visit(
          [&](const auto& target) {
            using Target = std::decay_t<decltype(target)>;
            EXPECT_TRUE(*target == *std::get<Target>(other.target)) << one.key;
          },
          one.target);
    }
  }
}

TEST(ConfigurationWriter, RandomCalibrationsAreReadBackToTheLastBit) {
  Random random(1);
  for (int k = 0; k < 500; ++k) {
    Device written;
    for (const Section& section : written.sections()) fill(section, random);
    CalibrationResult result = resultOf(written);
    if (k % 2 == 0) result.missing = {"angle map", "verification"};
    const std::string yaml = calibrationYaml(result, {1.0, 10.0, 1.0, 1.0});
    LoopConfiguration configuration = read(yaml);
    Device back{configuration.device, configuration.corrections};
    expectSame(written.sections(), back.sections());
    EXPECT_EQ(yaml.find("# PARTIAL") != std::string::npos, !result.missing.empty());
    // A parameter server has 32 bits for what it takes as an integer.
    const std::regex number("[:,\\[] -?([0-9]{10,})(?=[,\\] ])");
    for (std::sregex_iterator it(yaml.begin(), yaml.end(), number), end; it != end; ++it) {
      EXPECT_LE(std::stold((*it)[1]), 2147483647.0L) << it->str();
    }
  }
}

TEST(ConfigurationWriter, AnAngularGainJustAboveOneIsWrittenAndReadAsMeasured) {
  Device found;
  found.device = {14e3, 4e3, 1e6, 1.0000003};
  const LoopConfiguration read_back = read(calibrationYaml(resultOf(found), {14e3, 4e3, 1e6, 1.0}));
  EXPECT_EQ(read_back.device.angular_gain, 1.0000003);
}

/// Every number of the file, outside its range or not finite: no file, and a line that names it.
TEST(ConfigurationWriter, WritesNothingThatAReaderRefuses) {
  const std::size_t count = Device().sections()[0].table.parameters().size() +
                            Device().sections()[1].table.parameters().size();
  int tried = 0;
  for (std::size_t k = 0; k < count; ++k) {
    for (const double wrong : {-1e30, 1e30, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
      Device found;
      found.device = {14e3, 4e3, 1e6, 1.0};
      Sections sections = found.sections();
      const std::size_t first = sections[0].table.parameters().size();
      const Parameter& parameter =
          k < first ? sections[0].table.parameters()[k] : sections[1].table.parameters()[k - first];
      if (auto* const* number = std::get_if<double*>(&parameter.target)) {
        **number = wrong;
      } else if (auto* const* list = std::get_if<std::vector<double>*>(&parameter.target)) {
        (*list)->assign({0.0, wrong});
      } else {
        continue;
      }
      if (parameter.range.contains(wrong)) continue;
      ++tried;
      try {
        calibrationYaml(resultOf(found), found.device);
        ADD_FAILURE() << parameter.key << " = " << wrong;
      } catch (const std::runtime_error& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("/" + parameter.key), std::string::npos) << what;
        EXPECT_NE(what.find("allowed: "), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      }
    }
  }
  EXPECT_GT(tried, 60);
}

TEST(ConfigurationWriter, SectionsOfSomeKeysAreReadBackToTheLastBit) {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    LoopConfiguration written;
    for (const Section& section : written.sections()) {
      if (section.name == "device" || section.name == "resonator") fill(section, random);
    }
    Sections sections = written.sections();
    std::string yaml;
    for (const Section& section : sections) {
      if (section.name == "device") {
        yaml += configurationYaml(section, {"natural_frequency", "quality_factor", "drive_gain"});
      } else if (section.name == "resonator") {
        yaml += configurationYaml(
            section, {"natural_frequency", "quality_factor", "drive_gain", "tuning_voltage_0",
                      "tuning_voltage_90", "tuning_voltage_45", "tuning_voltage_135"});
      }
    }
    EXPECT_EQ(yaml.find("gamma1"), std::string::npos);
    const LoopConfiguration back = readConfiguration(YAML::Load(yaml));
    EXPECT_EQ(back.device.natural_frequency, written.device.natural_frequency);
    EXPECT_EQ(back.device.quality_factor, written.device.quality_factor);
    EXPECT_EQ(back.device.drive_gain, written.device.drive_gain);
    const ResonatorParameters& ring = back.plant.resonator;
    EXPECT_EQ(ring.drive_gain, written.plant.resonator.drive_gain);
    EXPECT_EQ(ring.tuning_voltage_0, written.plant.resonator.tuning_voltage_0);
    EXPECT_EQ(ring.tuning_voltage_90, written.plant.resonator.tuning_voltage_90);
    EXPECT_EQ(ring.tuning_voltage_45, written.plant.resonator.tuning_voltage_45);
    EXPECT_EQ(ring.tuning_voltage_135, written.plant.resonator.tuning_voltage_135);
  }
}

}  // namespace
}  // namespace cvg
