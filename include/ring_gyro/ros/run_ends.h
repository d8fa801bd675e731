#pragma once

#include <cstdint>
#include <map>

#include "ring_gyro/ros/bag_file.h"

namespace ring_gyro::bridge {

/// The last block that the plant announced, by session.
using RunEnds = std::map<std::uint32_t, std::uint64_t>;

/// Adds a sink that stores the end_of_run messages of a bag, from any topic, in `ends`; `ends` must
/// outlive the reading. Throws BagError when another version of this package wrote them.
void addRunEnds(const BagFile& bag, RunEnds& ends, BagSinks& sinks);

}  // namespace ring_gyro::bridge
