#pragma once

#include <cstdint>

namespace cvg {

/// The block of converter samples that a signal belongs to, and the time of that block.
///
/// Blocks are the clock of the loop: every signal carries the stamp of its block, signals are
/// paired by sequence, and durations come from stamps, never from a wall clock.
struct BlockStamp {
  std::uint32_t session = 0;     ///< differs at each start of the plant
  std::uint64_t sequence = 0;    ///< block number since that start
  std::int64_t end_ns = 0;       ///< end of the block [ns]
  std::int64_t duration_ns = 0;  ///< length of the block [ns]

  double duration() const { return 1e-9 * static_cast<double>(duration_ns); }  ///< [s]
  double end() const { return 1e-9 * static_cast<double>(end_ns); }            ///< [s]
};

}  // namespace cvg
