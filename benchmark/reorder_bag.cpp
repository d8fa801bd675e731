// Writes the same run with its messages in another order in the file:
//   reorder_bag RUN.bag OTHER.bag bursts|topics

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "ros/bag_fixture.h"

int main(int argc, char** argv) {
  using namespace ring_gyro::test;
  const std::string order = argc == 4 ? argv[3] : "";
  if (order != "bursts" && order != "topics") {
    std::fprintf(stderr, "usage: reorder_bag RUN.bag OTHER.bag bursts|topics\n");
    return EXIT_FAILURE;
  }
  try {
    constexpr std::uint32_t kChunk = 768 * 1024;  // as rosbag record writes
    reorderBag(argv[1], argv[2], order == "bursts" ? BagOrder::kBursts : BagOrder::kByTopic,
               rosbag::compression::LZ4, kChunk);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "reorder_bag: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
