#pragma once

#include <string>

#include "ring_gyro/calibration/calibration_result.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro {

/// The sections with all their keys and present values, as a configuration file has them.
std::string configurationYaml(const Sections& sections);

/// The file that a calibration run leaves: sections `device` and `calibration`, to be read after
/// the configuration of the run. `device`: as that configuration told the loops.
std::string calibrationYaml(const CalibrationResult& result, DeviceKnowledge device);

}  // namespace ring_gyro
