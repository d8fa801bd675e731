#pragma once

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Natural frequency [Hz] and damping ratio of a closed loop; the gains follow from the model.
struct LoopTuning {
  double bandwidth = 20.0;
  double damping = 1.0;
};

struct ControlParameters {
  double frequency_offset = 0.0;   ///< of the NCO at the start [Hz]
  double amplitude = 1.0;          ///< setpoint of a [V]
  double drive_limit = 10.0;       ///< amplitude per axis [V]
  double frequency_range = 200.0;  ///< largest deviation of the NCO from its start [Hz]
  double virtual_rate = 0.0;       ///< steering after lock, acts as a rotation k Om [rad/s]
  double hold_delay = 0.0;         ///< of the drive, corrected in its phase [s]
  double hold_gain = 1.0;          ///< of the drive, corrected in its amplitude
  LoopTuning phase_loop;
  LoopTuning amplitude_loop;
  LoopTuning quadrature_loop;
  LoopTuning angle_tracker;
  double learning_rate = 0.3;         ///< of the swings with the pattern angle; 0: off [1/s]
  double amplitude_modulation = 0.0;  ///< of the setpoint of a, relative; 0: none
  double amplitude_modulation_frequency = 0.5;  ///< [Hz]
  bool compensation = false;                    ///< wait for and apply the injector's decisions
  bool calibration_run = false;  ///< wait for and apply settings of a calibration run

  void declare(ParameterTable& table);
};

}  // namespace cvg
