#pragma once

#include <string>
#include <vector>

#include "ring_gyro/calibration/calibration_result.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// The sections with all their keys and present values, as a configuration file has them.
/// Throws std::runtime_error with a line for each value that the reader would refuse.
std::string configurationYaml(const Sections& sections);

/// The same of some keys of one section, in their order there.
std::string configurationYaml(const Section& section, const std::vector<std::string>& keys);

/// The file that a calibration run leaves: sections `device` and `calibration`, to be read after
/// the configuration of the run. `told`: the device as that configuration told the loops. The file
/// of a result that is not complete says what is missing. Throws as configurationYaml.
std::string calibrationYaml(const CalibrationResult& result, const DeviceKnowledge& told);

}  // namespace cvg
