#pragma once

#include <cstddef>
#include <cstdint>

#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::nodes {

// All queues of the loop are bounded, in messages, which are blocks. In lockstep none of the limits
// is reached (ReaderWait); in real time what is beyond them is lost, and seen as a gap by sequence.

/// Of a topic on its way to each of its readers: ten seconds of 1 ms.
constexpr std::uint32_t kOutputQueue = 10000;
/// Of a topic that a node reads: more than the socket holds, which is read in one go.
constexpr auto kInputQueue = static_cast<std::uint32_t>(cvg::PairMerge::kMostWaiting);

}  // namespace ring_gyro::nodes
