#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace {

std::atomic<bool> watching{false};
std::atomic<long> allocations{0};

void* allocate(std::size_t size, std::size_t alignment) {
  if (watching) ++allocations;
  void* const memory =
      alignment > alignof(std::max_align_t)
          ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
          : std::malloc(size > 0 ? size : 1);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Every new of this program, that of the libraries too.
void* operator new(std::size_t size) { return allocate(size, 1); }
void* operator new[](std::size_t size) { return allocate(size, 1); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace cvg {
namespace {

long allocationsOfLoop(const std::vector<std::string>& overrides, int blocks) {
  ClosedLoop loop(readConfigurationFile(RING_GYRO_CONFIG_DIR "/paper_experiment.yaml", overrides));
  loop.step();  // the start
  allocations = 0;
  watching = true;
  bool compensated = false;
  double truth = 0.0;
  for (int block = 1; block < blocks; ++block) {
    const LoopRecord record = loop.step();
    compensated = compensated || record.loops.gains.compensation.gain1 != 0.0;
    truth += record.truth().gamma1;
  }
  watching = false;
  EXPECT_TRUE(compensated);
  EXPECT_GT(truth, 0.0);
  return allocations;
}

TEST(Allocation, HookCounts) {
  allocations = 0;
  watching = true;
  std::vector<double> numbers(3);
  watching = false;
  EXPECT_EQ(numbers.size(), 3u);
  EXPECT_EQ(allocations, 1);
}

// Ring-up, lock, identification and compensation, in steps of 10 Hz and 1 kHz.
TEST(Allocation, ClosedLoopDoesNotAllocateAfterItsStart) {
  for (const char* period : {"0.1", "0.001"}) {
    SCOPED_TRACE(period);
    EXPECT_EQ(allocationsOfLoop({"control/compensation=true",
                                 std::string("identification/update_period=") + period},
                                20000),
              0);
  }
}

TEST(Allocation, NorSampleBySample) {
  EXPECT_EQ(allocationsOfLoop({"control/compensation=true", "drive/zero_order_hold=true",
                               "control/hold_delay=2.5e-6", "control/hold_gain=0.992",
                               "drive/noise_density=1e-6", "sense/adc_bits=24"},
                              20000),
            0);
}

}  // namespace
}  // namespace cvg
