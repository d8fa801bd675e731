#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "ring_gyro/common/block_stamp.h"
#include "ring_gyro/control/control_gains.h"
#include "ring_gyro/demodulation/orbital_elements.h"

namespace ring_gyro {

/// Constant inputs between two moments at which elements are valid.
struct ChainSegment {
  double duration = 0.0;                              ///< [s]
  double middle = 0.0;                                ///< 0 to 1 of the way between the moments
  Eigen::Vector2cd drive = Eigen::Vector2cd::Zero();  ///< commanded, with its step [V]
  double reference_frequency = 0.0;                   ///< [rad/s]
  double rotation_rate = 0.0;                         ///< k Om [rad/s]
};

/// Pairs measured elements with the inputs that acted between them, as Identifier does: elements
/// are valid a group delay before their block's end, inputs come from the blocks they acted in.
class BlockChain {
 public:
  struct Block {
    Orbit orbit;
    Eigen::Vector2cd drive = Eigen::Vector2cd::Zero();
    double reference_phase = 0.0;  ///< at its start [rad]
    double reference_frequency = 0.0;
    double rotation_rate = 0.0;
  };

  explicit BlockChain(std::int64_t block_duration_ns) : block_duration_ns_(block_duration_ns) {}

  /// Remembers the block when it can be used (rules of Identifier); true when everything that its
  /// elements depend on can be too.
  bool admit(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate);
  /// The next block follows nothing.
  void reset() { usable_run_ = 0; }

  const Block& block(std::uint64_t sequence) const { return memory_[sequence % kMemory]; }
  /// From where the elements of the block before `sequence` are valid to where its own are.
  /// Segments of no duration are to be skipped.
  std::array<ChainSegment, 2> segments(std::uint64_t sequence) const;

 private:
  static constexpr std::size_t kMemory = 64;

  bool setDelay(double group_delay, double duration);

  std::int64_t block_duration_ns_;
  std::array<Block, kMemory> memory_;
  BlockStamp last_stamp_;
  double group_delay_ = -1.0;        // of the present run of usable blocks [s]
  std::uint64_t whole_delay_ = 0;    // blocks in it
  double rest_of_delay_ = 0.0;       // what is left of it [s]
  std::uint64_t filter_memory_ = 1;  // blocks that go into an element
  std::uint64_t usable_run_ = 0;     // usable blocks without a break up to now
};

}  // namespace ring_gyro
