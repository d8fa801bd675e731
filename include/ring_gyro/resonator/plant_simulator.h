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

namespace cvg {

/// What no instrument shows: the motion itself at the end of a block, and the device.
struct PlantTruth {
  BlockStamp stamp;
  Eigen::Vector2cd envelope = Eigen::Vector2cd::Zero();  ///< against the NCO phase [V]
  double rotation_rate = 0.0;                            ///< mean over the block [rad/s]
  double rotation_angle = 0.0;                           ///< since the start [rad]
  double natural_frequency = 0.0;                        ///< at the present temperature [Hz]
  double quality_factor = 0.0;                           ///< at the present temperature
  double gamma1 = 0.0;                                   ///< at the present temperature
  double gamma2 = 0.0;                                   ///< at the present temperature
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

/// The gyroscope and its electronics in the time domain, one block of samples a step.
///
/// Linear resonator, rate constant in the block: exact, in one piece with an ideal modulator
/// (RingResonator), sample by sample with a held drive. Cubic stiffness, a gap that closes, or a
/// rate that varies within the block: sample by sample on the exact linear flow (SampledResonator),
/// error below 1e-7 over a second.
///
/// Same seed, same commands: same samples.
class PlantSimulator {
 public:
  /// `start_ns`: time of the start of block 0 [ns], above zero. Throws std::invalid_argument naming
  /// the parameter that cannot be used.
  PlantSimulator(const PlantParameters& parameters, const ConverterParameters& converter,
                 std::uint64_t seed, std::uint32_t session, std::int64_t start_ns);
  ~PlantSimulator();
  PlantSimulator(PlantSimulator&&) noexcept;
  PlantSimulator& operator=(PlantSimulator&&) noexcept;

  /// Block 0: nothing has been commanded, the drive is at rest.
  const DisplacementBlock& start();
  /// The next block under `command`. A command that is not finite is refused (std::domain_error).
  const DisplacementBlock& step(const DriveCommand& command);
  /// The next block without a new command: envelope and frequency stay, the phase runs on.
  const DisplacementBlock& coast();

  /// Rate of the case [rad/s] from the next block on, beside that of the rotation profile: a rate
  /// table at command, constant over a block. A rate that is not finite is refused
  /// (std::domain_error).
  void setRotationRate(double rate);
  /// Temperature deviation [K] from the next block on, beside what temperature_rate brings: a step.
  /// One that is not finite is refused (std::domain_error).
  void setTemperature(double deviation);

  /// Truth at the end of the last block.
  PlantTruth truth() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace cvg
