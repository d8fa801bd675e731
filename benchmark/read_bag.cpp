// Only reads a bag, the peer of identify:  read_bag RUN.bag

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bag_reading.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: read_bag RUN.bag\n");
    return EXIT_FAILURE;
  }
  try {
    std::printf("%llu messages\n",
                static_cast<unsigned long long>(ring_gyro::benchmark::readBag(argv[1])));
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "read_bag: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
