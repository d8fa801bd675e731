#include "ring_gyro/common/item_range.h"

#include <stdexcept>
#include <string>

namespace cvg {

std::vector<std::uint64_t> ItemRange::indices() const {
  if (shard >= shards) {
    throw std::invalid_argument("shard " + std::to_string(shard) + " of " + std::to_string(shards) +
                                ": must be 0 to one less than their number");
  }
  std::vector<std::uint64_t> result;
  for (std::uint64_t index = first; index < first + count; ++index) {
    if (index % shards == shard) result.push_back(index);
  }
  return result;
}

}  // namespace cvg
