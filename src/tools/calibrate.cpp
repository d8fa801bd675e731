// rosrun ring_gyro calibrate: a calibration run of the simulated gyroscope, in this process.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "command_line.h"
#include "configuration_options.h"
#include "harmonics_json.h"
#include "progress_bar.h"
#include "ring_gyro/calibration/calibration_report.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/staged_file.h"
#include "ring_gyro/configuration/configuration_writer.h"
#include "ring_gyro/simulation/calibration_run.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

using Result = std::function<void(const cvg::CalibrationResult&)>;

/// `found` is called with the results so far, each time that there are more.
cvg::CalibrationResult calibrate(const cvg::LoopConfiguration& configuration, const Result& found) {
  cvg::CalibrationRun run(configuration);
  ProgressBar progress(0.0);
  std::string leg;
  while (true) {
    const cvg::CalibrationRun::Step step = run.step();
    progress.show(run.time());
    if (!step.command) continue;
    if (!step.command->failure.empty()) throw std::runtime_error(step.command->failure);
    if (step.command->finished) return run.result();
    if (step.command->found) found(run.result());
    progress.setTotal(run.time() + step.command->time_left);
    if (step.command->leg != leg) {
      leg = step.command->leg;
      progress.clear();
      std::printf("%8.1f s  %s, %.0f s left\n", run.time(), leg.c_str(), step.command->time_left);
      std::fflush(stdout);
    }
  }
}

/// The measured values in SI units; the corrections are in the YAML.
nlohmann::json jsonOf(const cvg::CalibrationResult& result) {
  nlohmann::json json = {{"duration", result.duration},
                         {"steering_rate", result.steering_rate},
                         {"natural_frequency", result.device.natural_frequency},
                         {"quality_factor", result.device.quality_factor},
                         {"drive_gain", result.device.drive_gain},
                         {"angular_gain", result.device.angular_gain},
                         {"angle_map_measured", result.angle_map_measured},
                         {"angle_map", tools::jsonOf(result.corrections.angle_map)}};
  for (const cvg::IdentifiedParameter& parameter : result.parameters) {
    json["parameters"][parameter.name] = {{"value", parameter.value}, {"sigma", parameter.sigma}};
  }
  for (const cvg::DriftRound& round : result.drift_rounds) {
    json["drift_rounds"].push_back({{"peak_to_peak", round.peak_to_peak},
                                    {"sigma", round.sigma},
                                    {"measured", tools::jsonOf(round.measured)}});
  }
  for (const cvg::Verification& verification : result.verifications) {
    json["verifications"].push_back({{"rate", verification.rate},
                                     {"forward_peak", verification.forward_peak},
                                     {"backward_peak", verification.backward_peak},
                                     {"forward_scale", verification.forward_scale},
                                     {"backward_scale", verification.backward_scale},
                                     {"drift_peak_to_peak", verification.drift_peak_to_peak},
                                     {"drift", tools::jsonOf(verification.drift)}});
  }
  if (!result.missing.empty()) json["missing"] = result.missing;
  if (result.threshold) {
    const cvg::ThresholdTest& test = *result.threshold;
    json["threshold"] = {{"threshold", test.threshold}, {"worst_angle", test.worst_angle},
                         {"rate", test.rate},           {"turned", test.turned},
                         {"expected", test.expected},   {"followed", test.followed()}};
  }
  return json;
}

void run(const cvg::LoopConfiguration& configuration, const std::string& output_file,
         const std::string& json_file) {
  cvg::StagedFile output(output_file);
  cvg::StagedFile json(json_file);
  const auto textOf = [](const cvg::CalibrationResult& result) {
    return jsonOf(result).dump(1) + "\n";
  };
  try {
    const cvg::CalibrationResult result =
        calibrate(configuration, [&](const cvg::CalibrationResult& found) {
          json.keep(textOf(found));
          output.keep(cvg::calibrationYaml(found, configuration.device));
        });
    std::printf("\n%s", cvg::calibrationText(result).c_str());
    json.finish(textOf(result));
    output.finish(cvg::calibrationYaml(result, configuration.device));
  } catch (const std::exception& error) {
    if (output.kept().empty()) throw;
    throw std::runtime_error(std::string(error.what()) + "; what had been found is in " +
                             output.kept());
  }
  if (!output_file.empty()) std::printf("\ncalibration in %s\n", output_file.c_str());
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    ConfigurationOptions configuration_options;
    std::string output_file;
    std::string json_file;
    options::options_description description("calibrate");
    configuration_options.addTo(description);
    description.add_options()("help,h", "this text")(
        "output,o", options::value(&output_file),
        "YAML of the calibration; until it is complete, what has been found "
        "is in OUTPUT.partial")("json", options::value(&json_file),
                                "file for what was measured, in SI units");
    const options::variables_map values = parseCommandLine(argc, argv, description);
    if (values.count("help") != 0) {
      std::cout << "usage: calibrate --config FILE --output CALIBRATION.yaml\n" << description;
      return EXIT_SUCCESS;
    }
    const cvg::LoopConfiguration configuration = configuration_options.read();
    cvg::requireApart({output_file, json_file}, configuration.files);
    run(configuration, output_file, json_file);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
