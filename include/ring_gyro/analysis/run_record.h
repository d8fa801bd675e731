#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/loop_status.h"
#include "ring_gyro/signals/orbital_elements.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

/// The data of a run for one block; a part that never arrived keeps the default value.
struct RunBlock {
  std::int64_t end_ns = 0;  ///< 0: nothing arrived
  bool has_elements = false;
  bool has_gains = false;
  bool has_truth = false;
  Orbit measured;  ///< theta unwrapped
  LoopStatus status;
  double beta = 0.0;                 ///< [s]
  double alpha = 0.0;                ///< [V/V]
  double virtual_rate = 0.0;         ///< [rad/s]
  double reference_frequency = 0.0;  ///< [rad/s]
  DampingCompensation compensation;
  Orbit truth;  ///< theta in [-pi, pi]
};

/// One run in memory, about 0.2 kB per block: the data of the topics by block, whatever the order
/// in which the topics arrived.
class RunRecord {
 public:
  /// Each add() throws std::invalid_argument when the message is of another session, or so far from
  /// the others that it cannot be of the same run.
  void add(const OrbitalElements& elements);
  void add(const ControlGains& gains);
  void add(const PlantTruth& truth);
  void add(const ParameterEstimate& estimate);
  /// The plant has announced its last block.
  void end(std::uint32_t session, std::uint64_t last_sequence);

  const std::deque<RunBlock>& blocks() const { return blocks_; }
  const std::vector<ParameterEstimate>& estimates() const { return estimates_; }
  /// The last known state of the device.
  const std::optional<PlantTruth>& device() const { return device_; }

  /// Time since the start of the first block [s].
  double time(std::int64_t stamp_ns) const {
    return 1e-9 * static_cast<double>(stamp_ns - start_ns_);
  }
  double time(const RunBlock& block) const { return time(block.end_ns); }
  double blockDuration() const { return 1e-9 * static_cast<double>(duration_ns_); }  ///< [s]
  /// Group delay of the demodulator, from the last elements [s].
  double groupDelay() const { return group_delay_; }
  std::uint32_t session() const { return session_; }
  /// Whether the record ends before the run does: no end was announced, or the announced last block
  /// is missing.
  bool cut() const;
  /// Whether the case turned at any time.
  bool rotated() const { return rotated_; }

 private:
  RunBlock& at(const BlockStamp& stamp);

  std::deque<RunBlock> blocks_;
  std::vector<ParameterEstimate> estimates_;
  std::optional<PlantTruth> device_;
  std::uint32_t session_ = 0;
  std::uint64_t first_sequence_ = 0;
  std::int64_t start_ns_ = 0;
  std::int64_t duration_ns_ = 0;
  double group_delay_ = 0.0;
  bool rotated_ = false;
  std::map<std::uint32_t, std::uint64_t> ends_;  // last block by session
};

}  // namespace cvg
