#pragma once

#include <string>

#include "ring_gyro/calibration/calibration_result.h"

namespace cvg {

/// The result as printed tables, in degrees and seconds.
std::string calibrationText(const CalibrationResult& result);

}  // namespace cvg
