#include "ring_gyro/configuration/configuration_writer.h"

#include <algorithm>
#include <stdexcept>

#include "ring_gyro/configuration/parameter_text.h"

namespace cvg {
namespace {

std::string line(const Parameter& parameter) {
  const bool has_unit = !parameter.unit.empty() && parameter.unit != "1";
  return "  " + parameter.key + ": " + valueText(parameter) + "  # " +
         (has_unit ? parameter.unit + ", " : "") + parameter.description + "\n";
}

/// Other programs must be able to read the file: no file is better than one that they refuse.
void requireReadable(const Section& section) {
  try {
    requireInRange(section.table, section.name + "/");
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string(error.what()) +
                             "; it is not written, because no program would read it: is the device "
                             "as it was told?");
  }
}

}  // namespace

std::string configurationYaml(const Sections& sections) {
  std::string yaml;
  for (const Section& section : sections) {
    requireReadable(section);
    yaml += section.name + ":\n";
    for (const Parameter& parameter : section.table.parameters()) yaml += line(parameter);
  }
  return yaml;
}

std::string configurationYaml(const Section& section, const std::vector<std::string>& keys) {
  Section chosen{section.name, {}};
  std::string yaml = section.name + ":\n";
  for (const Parameter& parameter : section.table.parameters()) {
    if (std::find(keys.begin(), keys.end(), parameter.key) == keys.end()) continue;
    chosen.table.add(parameter);
    yaml += line(parameter);
  }
  requireReadable(chosen);
  return yaml;
}

std::string calibrationYaml(const CalibrationResult& result, const DeviceKnowledge& told) {
  DeviceKnowledge device = result.device;
  if (!result.angle_map_measured) device.angular_gain = told.angular_gain;
  Corrections corrections = result.corrections;
  Sections sections = {{"device", {}}, {"calibration", {}}};
  device.declare(sections[0].table);
  corrections.declare(sections[1].table);
  std::string head =
      "# Written by a calibration run; to be read after the configuration that it was made with.\n";
  if (!result.missing.empty()) {
    head += "# PARTIAL: the run has not ended. Missing:";
    for (const std::string& stage : result.missing) {
      head += (&stage == &result.missing.front() ? " " : ", ") + stage;
    }
    head += ".\n";
  }
  return head + configurationYaml(sections);
}

}  // namespace cvg
