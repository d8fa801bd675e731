// Measurements of the ROS-free core:  core_benchmark [--quick] [options of Google Benchmark]

#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

#include "filter_benchmark.h"

int main(int argc, char** argv) {
  using namespace ring_gyro;
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
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
