#pragma once

#include <cstddef>
#include <cstdint>

#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::nodes {

// All queues of the loop are bounded; limits are in messages (one per block). In lockstep no limit
// is reached (ReaderWait); in real time further messages are lost, which is seen as a gap by
// sequence.

/// Queue of a published topic for each of its readers: ten seconds of 1 ms blocks.
constexpr std::uint32_t kOutputQueue = 10000;
/// Queue of a topic that a node reads: more than the socket holds, because the socket is read at
/// once.
constexpr auto kInputQueue = static_cast<std::uint32_t>(cvg::PairMerge::kMostWaiting);

}  // namespace ring_gyro::nodes
