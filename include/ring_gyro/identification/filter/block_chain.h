#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/identification/filter/block_use.h"
#include "ring_gyro/identification/model/averaged_step.h"
#include "ring_gyro/identification/model/envelope_input.h"
#include "ring_gyro/signals/block_stamp.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Constant inputs between two moments at which elements are valid.
struct ChainSegment {
  double duration = 0.0;  ///< [s]
  double middle = 0.0;    ///< 0 to 1 of the way between the moments
  EnvelopeInput input;
};

/// Pairs measured elements with the inputs that acted between them: elements are valid a group
/// delay before their block's end, inputs come from the blocks they acted in, also where the delay
/// is not whole blocks.
///
/// A block can be used when its status says so, its numbers are finite, its stamp follows the one
/// before by exactly one block, and all of the demodulator's memory (twice the group delay) holds
/// such blocks.
class BlockChain {
 public:
  struct Block {
    Orbit orbit;
    Eigen::Vector2cd drive = Eigen::Vector2cd::Zero();
    double reference_phase = 0.0;  ///< at its start [rad]
    double reference_frequency = 0.0;
    double rotation_rate = 0.0;
  };

  /// How many blocks, the last with them, steps can be taken to; the longest delay is a block less,
  /// with a longer one no block can be used.
  static constexpr std::size_t kReach = 32;

  explicit BlockChain(std::int64_t block_duration_ns);

  /// Remembers the block when its own numbers can be used. kUsable when everything that its
  /// elements depend on can be too, else why it cannot be used.
  BlockUse admit(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate);
  /// The next block follows nothing.
  void reset() { usable_run_ = 0; }

  Block block(std::uint64_t sequence) const;
  double blockDuration() const { return block_duration_; }  ///< [s]

  /// From where the elements of the block before `sequence` are valid to where its own are.
  /// Segments of no duration are to be skipped.
  std::array<ChainSegment, 2> segments(std::uint64_t sequence) const;

  /// The same way as one step, for a ring whose envelope decays at `decay_rate` [1/s].
  void step(std::uint64_t sequence, double decay_rate, AveragedStep<double>& step) const;
  /// Also the steps to the blocks that follow `sequence`, as far as there are any.
  void steps(std::uint64_t sequence, double decay_rate, AveragedStep<Lanes>& steps) const;
  /// Measured axes of `sequence`, or of it and the blocks that follow [V].
  template <typename Real>
  void axes(std::uint64_t sequence, Real& a, Real& b) const {
    fetch(kMajor, sequence, a);
    fetch(kMinor, sequence, b);
  }

 private:
  // The step to the oldest block within reach needs what acted the longest delay before it.
  static constexpr std::size_t kMemory = 2 * kReach;
  // What later blocks need of a block, each kind of number by itself.
  enum Kind {
    kMajor,
    kMinor,
    kTheta,
    kPhi,
    kXReal,
    kXImaginary,
    kYReal,
    kYImaginary,
    kPhase,
    kFrequency,
    kRotation,
    kKinds
  };

  bool setDelay(double group_delay, double duration);
  template <typename Real>
  void stepTo(std::uint64_t sequence, double decay_rate, AveragedStep<Real>& step) const;
  template <typename Real>
  void fetch(Kind kind, std::uint64_t sequence, Real& to) const {
    std::memcpy(&to, &memory_[kind][sequence % kMemory], sizeof to);
  }

  std::int64_t block_duration_ns_;
  double block_duration_;
  // A ring; its beginning stands once more behind its end, so that lanes need not be broken.
  std::array<std::array<double, kMemory + kLanes>, kKinds> memory_;
  BlockStamp last_stamp_;
  double group_delay_ = -1.0;        // of the present run of usable blocks [s]
  std::uint64_t whole_delay_ = 0;    // blocks in it
  double rest_of_delay_ = 0.0;       // what is left of it [blocks]
  std::uint64_t filter_memory_ = 1;  // blocks that go into an element
  std::uint64_t usable_run_ = 0;     // usable blocks without a break up to now
};

}  // namespace cvg
