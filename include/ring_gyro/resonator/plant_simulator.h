#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/resonator/electronics_parameters.h"
#include "ring_gyro/resonator/resonator_parameters.h"
#include "ring_gyro/resonator/rotation_profile.h"
#include "ring_gyro/signals/displacement_block.h"
#include "ring_gyro/signals/drive_command.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {

/// True values that no instrument shows: the motion at the end of a block, and the device.
struct PlantTruth {
  BlockStamp stamp;
  Envelope envelope = Envelope::Zero();  ///< against the NCO phase [V]
  double rotation_rate = 0.0;            ///< mean over the block [rad/s]
  double rotation_angle = 0.0;           ///< since the start [rad]
  double natural_frequency = 0.0;        ///< at the present temperature [Hz]
  double quality_factor = 0.0;           ///< at the present temperature
  double gamma1 = 0.0;                   ///< at the present temperature
  double gamma2 = 0.0;                   ///< at the present temperature
  double mu1 = 0.0;
  double mu2 = 0.0;
  double drive_gain = 0.0;  ///< ks [1/s^2]
};

struct PlantParameters {
  ResonatorParameters resonator;
  SenseParameters sense;
  DriveParameters drive;
  RotationParameters rotation;
};

/// The gyroscope and its electronics in the time domain, one block of samples per step.
///
/// A linear resonator with a constant rate in the block is solved exactly: for a whole block with
/// an ideal modulator (RingResonator), sample by sample with a held drive. With cubic stiffness, a
/// gap that closes, or a rate that varies within the block, each sample is a step on top of the
/// exact linear flow (SampledResonator); the error is below 1e-7 over a second.
///
/// The same seed and the same commands give the same samples.
class PlantSimulator {
 public:
  /// `start_ns`: time of the start of block 0 [ns], above zero. Throws std::invalid_argument,
  /// naming a parameter that cannot be used.
  PlantSimulator(const PlantParameters& parameters, const ConverterParameters& converter,
                 std::uint64_t seed, std::uint32_t session, std::int64_t start_ns);
  ~PlantSimulator();
  PlantSimulator(PlantSimulator&&) noexcept;
  PlantSimulator& operator=(PlantSimulator&&) noexcept;

  /// Block 0: nothing has been commanded yet, the drive is zero.
  const DisplacementBlock& start();
  /// The next block under `command`. A command that is not finite is refused (std::domain_error).
  const DisplacementBlock& step(const DriveCommand& command);
  /// The next block without a new command: envelope and frequency stay, the phase continues.
  const DisplacementBlock& coast();

  /// Rate of the case [rad/s] from the next block on, added to that of the rotation profile: a
  /// commanded rate table, constant over a block. A rate that is not finite is refused
  /// (std::domain_error).
  void setRotationRate(double rate);
  /// Step of the temperature deviation [K] from the next block on, added to that of
  /// temperature_rate. A deviation that is not finite is refused (std::domain_error).
  void setTemperature(double deviation);

  /// Truth at the end of the last block.
  PlantTruth truth() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace cvg
