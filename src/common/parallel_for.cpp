#include "ring_gyro/common/parallel_for.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cvg {

std::size_t coreCount() { return std::max(1u, std::thread::hardware_concurrency()); }

void parallelFor(std::size_t count, std::size_t threads,
                 const std::function<void(std::size_t)>& work) {
  std::mutex mutex;
  std::size_t next = 0;
  std::size_t thrower = count;
  std::exception_ptr thrown;
  const auto take = [&] {
    for (;;) {
      std::size_t mine = count;
      {
        const std::lock_guard<std::mutex> lock(mutex);
        if (next == count) return;
        mine = next++;
      }
      try {
        work(mine);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        next = count;
        if (mine < thrower) {
          thrower = mine;
          thrown = std::current_exception();
        }
      }
    }
  };
  std::vector<std::thread> others;
  const std::size_t wanted = std::min(std::max<std::size_t>(threads, 1), count);
  for (std::size_t k = 1; k < wanted; ++k) others.emplace_back(take);
  take();
  for (std::thread& other : others) other.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace cvg
