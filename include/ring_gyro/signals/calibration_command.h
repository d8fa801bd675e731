#pragma once

#include <cstdint>
#include <string>

#include "ring_gyro/signals/corrections.h"

namespace cvg {

/// What a calibration run sets in the loops while they run.
struct LoopSettings {
  double virtual_rate = 0.0;                    ///< steering, as the equal rotation k Om [rad/s]
  double table_rate = 0.0;                      ///< of the rate table [rad/s]
  double amplitude_modulation = 0.0;            ///< of the setpoint of a, relative
  double amplitude_modulation_frequency = 0.5;  ///< [Hz]
  bool end_of_run = false;                      ///< the plant is no longer needed
  Corrections corrections;
};

/// What a calibration run commands the loops to do, and its progress.
struct CalibrationCommand {
  std::uint32_t session = 0;
  std::uint64_t effective_sequence = 0;  ///< first block whose drive it applies to
  LoopSettings settings;
  std::string leg;         ///< name of the current step, for display
  double time_left = 0.0;  ///< by the present plan [s]
  bool found = false;      ///< the result contains more than at the last command
  bool finished = false;   ///< the result is complete
  std::string failure;     ///< why the run cannot continue; empty: it can
};

}  // namespace cvg
