#pragma once

#include "ring_gyro/control/calibration.h"

namespace cvg {

/// What a calibration run sets in the loops while they run.
struct LoopSettings {
  double virtual_rate = 0.0;                    ///< steering, as a rotation k Om of this [rad/s]
  double table_rate = 0.0;                      ///< of the rate table [rad/s]
  double amplitude_modulation = 0.0;            ///< of the setpoint of a, relative
  double amplitude_modulation_frequency = 0.5;  ///< [Hz]
  bool end_of_run = false;                      ///< nothing more is needed of the plant
  Calibration calibration;
};

}  // namespace cvg
