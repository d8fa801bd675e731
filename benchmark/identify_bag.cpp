// Time of identifying from a bag against the time of merely reading it:  identify_bag RUN.bag
// CONFIG.yaml [repetitions]
//
// Reading is a rosbag::View over orbital elements and control gains, each message copied out and
// dropped. Both include opening the file. The least of several turns, taken alternately, is
// compared, so that other work on the machine hits both alike.

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/ros/bag_identification.h"

namespace ring_gyro {
namespace {

class Bytes {
 public:
  std::uint8_t* advance(std::uint32_t size) {
    if (bytes_.size() < size) bytes_.resize(size);
    return bytes_.data();
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

std::uint64_t readOnly(const std::string& path) {
  const rosbag::Bag bag(path);
  rosbag::View view(bag, [](const rosbag::ConnectionInfo* connection) {
    return connection->datatype == "ring_gyro/OrbitalElements" ||
           connection->datatype == "ring_gyro/ControlGains";
  });
  Bytes bytes;
  std::uint64_t messages = 0;
  for (const rosbag::MessageInstance& instance : view) {
    instance.write(bytes);
    ++messages;
  }
  return messages;
}

double cpuTime() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Least wall and processor time seen [s].
struct Least {
  double wall = std::numeric_limits<double>::infinity();
  double cpu = std::numeric_limits<double>::infinity();

  template <typename Work>
  void time(Work work) {
    const auto begin = std::chrono::steady_clock::now();
    const double cpu_begin = cpuTime();
    work();
    wall = std::min(
        wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    cpu = std::min(cpu, cpuTime() - cpu_begin);
  }
};

int run(const std::string& path, const std::string& configuration_file, int repetitions) {
  const LoopConfiguration configuration = readConfigurationFile(configuration_file);
  std::uint64_t messages = 0;
  Least reading;
  Least identifying;
  for (int i = 0; i < repetitions; ++i) {
    reading.time([&] { messages = readOnly(path); });
    identifying.time([&] { BagIdentification({path}, configuration).run(); });
  }
  std::printf("messages     %llu\n", static_cast<unsigned long long>(messages));
  std::printf("reading      %.3f s wall, %.3f s processor\n", reading.wall, reading.cpu);
  std::printf("identifying  %.3f s wall, %.3f s processor\n", identifying.wall, identifying.cpu);
  std::printf("ratio        %.3f wall, %.3f processor\n", identifying.wall / reading.wall,
              identifying.cpu / reading.cpu);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace ring_gyro

int main(int argc, char** argv) {
  try {
    if (argc < 3) {
      std::fprintf(stderr, "usage: identify_bag RUN.bag CONFIG.yaml [repetitions]\n");
      return EXIT_FAILURE;
    }
    return ring_gyro::run(argv[1], argv[2], argc > 3 ? std::max(1, std::atoi(argv[3])) : 5);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "identify_bag: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
