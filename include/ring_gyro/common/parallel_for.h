#pragma once

#include <cstddef>
#include <functional>

namespace cvg {

/// Number of cores.
std::size_t coreCount();

/// Calls work(k) for each k from 0 to `count` - 1 on `threads` threads, one of which is the calling
/// thread. Calls start in the order of k. After a call has thrown, no new calls start; when all
/// running calls have ended, the exception of the lowest k is thrown.
void parallelFor(std::size_t count, std::size_t threads,
                 const std::function<void(std::size_t)>& work);

}  // namespace cvg
