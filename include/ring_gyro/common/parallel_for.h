#pragma once

#include <cstddef>
#include <functional>

namespace cvg {

/// As many threads as there are cores.
std::size_t coreCount();

/// Calls work(k) for each k from 0 to `count` - 1, in that order as far as `threads` of them go on
/// at once; the calling thread is one of them. When one throws, no more are begun, and what the one
/// with the lowest k threw is thrown from here once all have ended.
void parallelFor(std::size_t count, std::size_t threads,
                 const std::function<void(std::size_t)>& work);

}  // namespace cvg
