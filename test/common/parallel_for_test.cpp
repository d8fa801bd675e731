#include "ring_gyro/common/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace cvg {
namespace {

TEST(ParallelFor, DoesEachOnce) {
  for (const std::size_t threads : {0, 1, 2, 7, 100}) {
    for (const std::size_t count : {0, 1, 3, 1000}) {
      std::vector<std::atomic<int>> done(count);
      parallelFor(count, threads, [&](std::size_t k) { ++done[k]; });
      for (const std::atomic<int>& times : done) ASSERT_EQ(times, 1) << threads << " " << count;
    }
  }
}

TEST(ParallelFor, OneThreadGoesInOrder) {
  std::vector<std::size_t> order;
  parallelFor(100, 1, [&](std::size_t k) { order.push_back(k); });
  for (std::size_t k = 0; k < order.size(); ++k) EXPECT_EQ(order[k], k);
}

TEST(ParallelFor, ThrowsWhatTheLowestThrewAndBeginsNoMore) {
  for (const std::size_t threads : {1, 4}) {
    std::atomic<int> begun{0};
    try {
      parallelFor(100000, threads, [&](std::size_t k) {
        ++begun;
        if (k >= 10) throw std::runtime_error(std::to_string(k));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "10");
    }
    EXPECT_LT(begun, 100);
  }
}

}  // namespace
}  // namespace cvg
