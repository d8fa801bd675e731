#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace ring_gyro {

/// The last block that the plant announced, by session.
using RunEnds = std::map<std::uint32_t, std::uint64_t>;

/// What the end_of_run messages of a bag say, whatever their topic; of a bag without an index as
/// far as it can be read. Throws BagError when it cannot be read at all.
RunEnds runEnds(const std::string& path);

}  // namespace ring_gyro
