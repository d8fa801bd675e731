// rosrun ring_gyro calibrate: a calibration run of the simulated gyroscope, in this process.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

#include "configuration_options.h"
#include "progress_bar.h"
#include "ring_gyro/calibration/calibration_report.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/configuration/configuration_writer.h"
#include "ring_gyro/simulation/calibration_run.h"

namespace ring_gyro {
namespace {

namespace options = boost::program_options;

CalibrationResult calibrate(const LoopConfiguration& configuration) {
  CalibrationRun run(configuration);
  ProgressBar progress(0.0);
  std::string leg;
  while (true) {
    const CalibrationRun::Step step = run.step();
    progress.show(run.time());
    if (!step.command) continue;
    if (!step.command->failure.empty()) throw std::runtime_error(step.command->failure);
    if (step.command->finished) return run.result();
    progress.setTotal(run.time() + step.command->time_left);
    if (step.command->leg != leg) {
      leg = step.command->leg;
      progress.clear();
      std::printf("%8.1f s  %s, %.0f s left\n", run.time(), leg.c_str(), step.command->time_left);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace ring_gyro

int main(int argc, char** argv) {
  using namespace ring_gyro;
  try {
    ConfigurationOptions configuration_options;
    std::string output_file;
    options::options_description description("calibrate");
    configuration_options.addTo(description);
    description.add_options()("help,h", "this text")("output,o", options::value(&output_file),
                                                     "YAML of the calibration");
    options::variables_map values;
    options::store(options::parse_command_line(argc, argv, description), values);
    options::notify(values);
    if (values.count("help") != 0) {
      std::cout << "usage: calibrate --config FILE --output CALIBRATION.yaml\n" << description;
      return EXIT_SUCCESS;
    }
    const LoopConfiguration configuration = configuration_options.read();
    const CalibrationResult result = calibrate(configuration);
    std::printf("\n%s", calibrationText(result).c_str());
    if (!output_file.empty()) {
      writeWholeFile(output_file, calibrationYaml(result, configuration.device));
      std::printf("\ncalibration in %s\n", output_file.c_str());
    }
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
