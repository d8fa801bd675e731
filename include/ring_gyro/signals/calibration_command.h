#pragma once

#include <cstdint>
#include <string>

#include "ring_gyro/signals/corrections.h"

namespace cvg {

/// What a calibration run sets in the loops while they run.
struct LoopSettings {
  double virtual_rate = 0.0;                    ///< steering, as a rotation k Om of this [rad/s]
  double table_rate = 0.0;                      ///< of the rate table [rad/s]
  double amplitude_modulation = 0.0;            ///< of the setpoint of a, relative
  double amplitude_modulation_frequency = 0.5;  ///< [Hz]
  bool end_of_run = false;                      ///< nothing more is needed of the plant
  Corrections corrections;
};

/// What a calibration run asks of the loops, and how far it is.
struct CalibrationCommand {
  std::uint32_t session = 0;
  std::uint64_t effective_sequence = 0;  ///< first block whose drive it applies to
  LoopSettings settings;
  std::string leg;         ///< what is being done, for people
  double time_left = 0.0;  ///< as planned now [s]
  bool found = false;      ///< the result holds more than at the command before
  bool finished = false;   ///< the result is complete
  std::string failure;     ///< why the run cannot go on; empty: it can
};

}  // namespace cvg
