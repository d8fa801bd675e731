#pragma once

#include <cstdint>

#include "ring_gyro/calibration/calibration_parameters.h"
#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/compensation/compensation_injector.h"
#include "ring_gyro/control/control_parameters.h"
#include "ring_gyro/demodulation/demodulator.h"
#include "ring_gyro/identification/filter/identifier.h"
#include "ring_gyro/identification/model/extended_parameters.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/corrections.h"

namespace cvg {

/// Settings of a simulation run.
struct RunParameters {
  double duration = 130.0;   ///< simulated; 0: until stopped [s]
  std::int64_t seed = 1;     ///< of all noise
  std::int64_t session = 1;  ///< 0: from the wall clock
  double start_time = 1.0;   ///< stamp of the start of block 0 [s]

  std::int64_t startNanoseconds() const;
  /// `session`, or if this is 0 a number from the wall clock that no other start has.
  std::uint32_t sessionIdentifier() const;
  /// The `session` for the next start, so that it differs from this one.
  std::int64_t followingSession() const;
  /// Blocks in `duration`; 0: until stopped.
  std::uint64_t blocks(const ConverterParameters& converter) const;
  void declare(ParameterTable& table);
};

/// The complete configuration of a run of the loop; nodes and tools read it from one YAML file.
struct LoopConfiguration {
  RunParameters run;
  ConverterParameters converter;
  DeviceKnowledge device;
  PlantParameters plant;
  DemodulationParameters demodulation;
  ControlParameters control;
  Corrections corrections;
  IdentificationParameters identification;
  ExtendedParameters extended;
  InjectorParameters compensation;
  CalibrationRunParameters calibration_run;
  /// Files that it was read from, including the rotation file: no output may be one of them.
  std::vector<std::string> files;

  /// The sections in the order of the file: run, converter, device, resonator, sense, drive,
  /// rotation, demodulation, control, calibration, identification, extended, compensation,
  /// calibration_run. The tables point into this object.
  Sections sections();

  /// Blocks in a period of the identifier. Throws std::invalid_argument when it is not whole.
  std::uint64_t periodBlocks() const;
};

}  // namespace cvg
