#pragma once

#include <cstdint>
#include <vector>

namespace cvg {

/// Items of a batch: indices first to first + count - 1, of which shard k of n takes those with
/// index % n == k.
struct ItemRange {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
  std::uint64_t shard = 0;
  std::uint64_t shards = 1;

  /// Throws std::invalid_argument unless shard < shards.
  std::vector<std::uint64_t> indices() const;
};

}  // namespace cvg
