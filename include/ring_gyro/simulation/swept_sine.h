#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/demodulation/demodulator.h"
#include "ring_gyro/identification/model/frequency_response.h"
#include "ring_gyro/resonator/plant_simulator.h"

namespace cvg {

/// Settings of the open-loop sine sweep and ring-down of a device.
struct SweepParameters {
  double centre = 0.0;  ///< [Hz]
  double span = 4.0;    ///< of the sweep about the centre [Hz]
  std::int64_t points = 41;
  double drive = 0.5;           ///< amplitude [V]
  double settling = 6.0;        ///< at each frequency before the measurement [s]
  double averaging = 0.2;       ///< of the measurement [s]
  double ring_down_time = 2.0;  ///< recorded after the drive is switched off [s]

  void declare(ParameterTable& table);
};

using Progress = std::function<void(double)>;  ///< share done, 0 to 1

/// Measures the response matrix, including the electronics of the simulated device: drives x, then
/// y.
std::vector<FrequencyPoint> sweepSine(const PlantParameters& plant,
                                      const ConverterParameters& converter,
                                      const DemodulationParameters& demodulation,
                                      const SweepParameters& sweep, std::uint64_t seed,
                                      const Progress& progress);

/// Rings up along x, then along y; after each, switches the drive off and records the decay.
RingDown recordRingDown(const PlantParameters& plant, const ConverterParameters& converter,
                        const DemodulationParameters& demodulation, const SweepParameters& sweep,
                        std::uint64_t seed);

}  // namespace cvg
