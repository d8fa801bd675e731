// rosrun ring_gyro tune_modes: from the identified stiffness mismatch to tuning voltages.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "configuration_options.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/configuration/configuration_writer.h"
#include "ring_gyro/simulation/mode_tuning.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

std::string voltageSection(const cvg::TuningPass& pass) {
  cvg::ResonatorParameters ring;
  pass.squares.applyTo(ring);
  cvg::Section section{"resonator", {}};
  ring.declare(section.table);
  return cvg::formatted("# Found by tune_modes: identified split %.3e Hz.\n", pass.split) +
         cvg::configurationYaml(section, {"tuning_voltage_0", "tuning_voltage_90",
                                          "tuning_voltage_45", "tuning_voltage_135"});
}

void run(const cvg::LoopConfiguration& configuration, const cvg::TuningOptions& tuning,
         const std::string& output_file) {
  cvg::requireApart({output_file}, configuration.files);
  cvg::WholeFile output(output_file);
  std::printf("pass  V(0)      V(90)     V(45)     V(135)    identified split   true split\n");
  int number = 0;
  const std::vector<cvg::TuningPass> passes =
      cvg::tuneModes(configuration, tuning, [&](const cvg::TuningPass& pass) {
        cvg::ResonatorParameters ring;
        pass.squares.applyTo(ring);
        std::printf("%4d  %8.4f  %8.4f  %8.4f  %8.4f  %12.4e Hz    %12.4e Hz\n", ++number,
                    ring.tuning_voltage_0, ring.tuning_voltage_90, ring.tuning_voltage_45,
                    ring.tuning_voltage_135, pass.split, pass.true_split);
        std::fflush(stdout);
      });
  output.finish(voltageSection(passes.back()));
  if (passes.back().split >= tuning.target_split) {
    throw std::runtime_error(
        "tune_modes: the split is still above --target after --passes; allow more "
        "of either, or a longer --time");
  }
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    ConfigurationOptions configuration_options;
    cvg::TuningOptions tuning;
    std::string output_file;
    options::options_description description("tune_modes");
    configuration_options.addTo(description);
    description.add_options()("help,h", "this text")(
        "gain", options::value(&tuning.assumed_tuning_gain),
        "softening of a tuning electrode relative to w0^2 [1/V^2]; resonator/tuning_gain if "
        "absent")("time", options::value(&tuning.identification_time)->default_value(30.0),
                  "of identification a pass [s]")(
        "target", options::value(&tuning.target_split)->default_value(1e-4), "split to reach [Hz]")(
        "passes", options::value(&tuning.most_passes)->default_value(6), "at the most")(
        "output,o", options::value(&output_file), "YAML with the voltages");
    const options::variables_map values = parseCommandLine(argc, argv, description);
    if (values.count("help") != 0) {
      std::cout << "usage: tune_modes --config FILE [--output VOLTAGES.yaml]\n" << description;
      return EXIT_SUCCESS;
    }
    const cvg::LoopConfiguration configuration = configuration_options.read();
    if (tuning.assumed_tuning_gain == 0.0) {
      tuning.assumed_tuning_gain = configuration.plant.resonator.tuning_gain;
    }
    cvg::ParameterTable table;
    tuning.declare(table);
    cvg::requireInRange(table, "--");
    run(configuration, tuning, output_file);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
