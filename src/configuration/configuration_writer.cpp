#include "ring_gyro/configuration/configuration_writer.h"

#include "ring_gyro/configuration/parameter_text.h"

namespace ring_gyro {

std::string configurationYaml(const Sections& sections) {
  std::string yaml;
  for (const Section& section : sections) {
    yaml += section.name + ":\n";
    for (const Parameter& parameter : section.table.parameters()) {
      yaml += "  " + parameter.key + ": " + valueText(parameter) + "  # ";
      const bool has_unit = !parameter.unit.empty() && parameter.unit != "1";
      yaml += (has_unit ? parameter.unit + ", " : "") + parameter.description + "\n";
    }
  }
  return yaml;
}

std::string calibrationYaml(const CalibrationResult& result, DeviceKnowledge device) {
  device.natural_frequency = result.natural_frequency;
  device.quality_factor = result.quality_factor;
  device.drive_gain = result.drive_gain;
  if (result.angle_map_measured) device.angular_gain = result.angular_gain;
  Calibration calibration = result.calibration;
  Sections sections = {{"device", {}}, {"calibration", {}}};
  device.declare(sections[0].table);
  calibration.declare(sections[1].table);
  return "# Written by a calibration run; to be read after the configuration that it was made "
         "with.\n" +
         configurationYaml(sections);
}

}  // namespace ring_gyro
