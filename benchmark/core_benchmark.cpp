// Measurements of the core without ROS:  core_benchmark [--quick] [options of Google Benchmark]

#include <benchmark/benchmark.h>

#include <cstring>
#include <string>
#include <vector>

#include "filter_benchmark.h"
#include "loop_benchmark.h"

int main(int argc, char** argv) {
  using namespace cvg;
  bool quick = false;
  std::vector<char*> arguments;
  for (int i = 0; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0) {
      quick = true;
    } else {
      arguments.push_back(argv[i]);
    }
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 1;

  const auto add = [](const char* name, auto work, int turns) {
    benchmark::RegisterBenchmark(name, work)->UseManualTime()->Iterations(turns);
  };
  add("filter_speed", filterAgainstDense, quick ? 40 : 300);
  add(
      "filter_accuracy",
      [quick](benchmark::State& state) { filterAccuracy(state, quick ? 30000 : 300000); }, 1);
  const std::string file = RING_GYRO_CONFIG_DIR "/paper_simulation.yaml";
  add("plant", plantAgainstOdeint, quick ? 20 : 100);
  add(
      "closed_loop", [&file](benchmark::State& state) { loopAgainstPlain(state, file); },
      quick ? 20 : 100);
  for (const double period : {0.1, 0.001}) {
    add(
        period < 0.01 ? "chain_1kHz" : "chain_10Hz",
        [&file, period](benchmark::State& state) { chainAgainstLoop(state, file, period); },
        quick ? 30 : 200);
  }
  add(
      "flat_cost",
      [&file, quick](benchmark::State& state) {
        oldAgainstYoung(state, file, quick ? 600.0 : 10800.0);
      },
      quick ? 50 : 400);
  add(
      "monte_carlo", [&file](benchmark::State& state) { twoCoresAgainstOne(state, file); },
      quick ? 5 : 15);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
