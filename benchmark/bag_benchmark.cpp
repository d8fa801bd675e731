// identify against a bare read of the same bag:  bag_benchmark RUN.bag CONFIG.yaml [options of
// Google Benchmark]

#include <benchmark/benchmark.h>
#include <time.h>

#include <cstdio>
#include <string>

#include "bag_reading.h"
#include "interleaved.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/ros/bag_identification.h"

namespace {

/// Of all threads of this process [s].
double processTime() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace cvg;
  if (argc < 3) {
    std::fprintf(stderr, "usage: bag_benchmark RUN.bag CONFIG.yaml [options]\n");
    return 1;
  }
  const std::string path = argv[1];
  const cvg::LoopConfiguration configuration = cvg::readConfigurationFile(argv[2]);
  argv[2] = argv[0];
  int count = argc - 2;
  benchmark::Initialize(&count, argv + 2);
  const auto add = [&](const char* name, double (*clock)()) {
    benchmark::RegisterBenchmark(
        name,
        [&, clock](benchmark::State& state) {
          timeInTurns(
              state, clock, 1.0,
              [&] { ring_gyro::bridge::BagIdentification({path}, configuration).run(); }, 1.0,
              [&] { benchmark::DoNotOptimize(ring_gyro::benchmark::readBag(path)); });
        })
        ->UseManualTime()
        ->Iterations(11);
  };
  add("identify_wall", wallTime);
  add("identify_processor", processTime);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
