#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/control/control_parameters.h"
#include "ring_gyro/control/drive_synthesis.h"
#include "ring_gyro/control/lock_detector.h"
#include "ring_gyro/control/loop_filter.h"
#include "ring_gyro/control/pattern_feedforward.h"
#include "ring_gyro/demodulation/demodulator.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/corrections.h"
#include "ring_gyro/signals/displacement_block.h"
#include "ring_gyro/signals/drive_command.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Result of one displacement block.
struct LoopOutput {
  OrbitalElements elements;
  ControlGains gains;
  DriveCommand command;
};

/// Demodulation and the four loops of a whole-angle gyroscope: phase (PLL), amplitude, quadrature
/// and precession steering; one step per block.
///
/// From rest the loops drive along x at the limit until there is an orbit to control; then they
/// close. When the orbit is lost they begin again. When samples or the reference are not finite, or
/// blocks are missing, the loops coast: the last drive continues, the loops do not learn, and the
/// status says so. A block of another session restarts the loops.
///
/// The drive that is sent, with all corrections, stays within the drive limit on each axis. If it
/// had to be scaled down, or the plant's converter clipped it, the status of the block in which it
/// acted says so.
class ControlLoops {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used.
  ControlLoops(const DeviceKnowledge& device, const ControlParameters& control,
               const DemodulationParameters& demodulation, const ConverterParameters& converter,
               const Corrections& corrections = {});

  /// Processes one block. The returned reference is valid until the next call.
  const LoopOutput& process(const DisplacementBlock& block);

  /// Back to the state and settings after construction: forgets all measurements, learnt values and
  /// decisions.
  void restart();

  /// Damping compensation from the next command on.
  void setCompensation(const DampingCompensation& compensation) { compensation_ = compensation; }
  /// Steering, modulation and corrections from the next block on.
  void setSettings(const LoopSettings& settings);

  double groupDelay() const { return demodulator_.groupDelay(); }

 private:
  struct ActedDrive {
    std::uint64_t answers_sequence = 0;
    bool known = false;
    ControlGains gains;
    bool saturated = false;
  };
  static constexpr std::size_t kDriveMemory = 64;

  /// Reference for the demodulation of a block.
  struct Reference {
    double phase = 0.0;      // of the NCO at the first sample [rad]
    double frequency = 0.0;  // [rad/s]
  };

  bool samplesUsable(const DisplacementBlock& block) const;
  Reference runOn(std::uint64_t blocks, double period) const;
  void measure(const Envelope& envelope, double period);
  void recallActedDrive(const DisplacementBlock& block, const Reference& reference);
  void command(const DisplacementBlock& block, const Reference& reference);
  Envelope sentFor(const Envelope& total) const;
  DriveGains closeLoops(double theta);
  double amplitudeSetpoint() const;

  DeviceKnowledge device_;
  ControlParameters parameters_;
  DemodulationParameters demodulation_;
  ConverterParameters converter_;
  Corrections corrections_;  // as at construction
  Demodulator demodulator_;
  AngleUnwrapper unwrapper_;
  LoopFilter phase_loop_;
  LoopFilter amplitude_loop_;
  LoopFilter quadrature_loop_;
  PatternFeedforward frequency_feedforward_;
  PatternFeedforward quadrature_feedforward_;
  LoopGains angle_tracker_gains_;
  LockDetector amplitude_lock_;
  LockDetector quadrature_lock_;
  LockDetector phase_lock_;
  std::int64_t blocks_to_settle_ = 0;
  bool started_ = false;
  BlockStamp last_stamp_;
  double lead_;  // from the time of the elements to the middle of the drive computed from them [s]
  double tracked_theta_ = 0.0;
  double theta_rate_ = 0.0;
  bool orbit_found_ = false;
  bool was_locked_ = false;
  double frequency_;
  LoopSettings settings_;
  Eigen::Matrix2cd drive_correction_;  // of settings_.corrections
  DampingCompensation compensation_;
  std::array<ActedDrive, kDriveMemory> drives_;
  LoopOutput output_;
};

}  // namespace cvg
