#pragma once

#include <string>
#include <vector>

#include "ring_gyro/calibration/calibration_result.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// The sections with all their keys and present values, in the form of a configuration file.
/// Throws std::runtime_error with a line for each value that the reader would refuse.
std::string configurationYaml(const Sections& sections);

/// The same for some keys of one section, in the order of the section.
std::string configurationYaml(const Section& section, const std::vector<std::string>& keys);

/// The file of a calibration run: sections `device` and `calibration`, to be read after the
/// configuration of the run. `told`: the nominal device in that configuration. If the result is not
/// complete, the file says what is missing. Throws like configurationYaml.
std::string calibrationYaml(const CalibrationResult& result, const DeviceKnowledge& told);

}  // namespace cvg
