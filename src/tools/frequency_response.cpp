// rosrun ring_gyro frequency_response: swept sine and ring-down of the simulated device.

#include "ring_gyro/identification/model/frequency_response.h"

#include <boost/program_options.hpp>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "command_line.h"
#include "configuration_options.h"
#include "progress_bar.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/configuration/configuration_writer.h"
#include "ring_gyro/simulation/swept_sine.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

struct Arguments {
  ConfigurationOptions configuration;
  cvg::SweepParameters sweep;
  std::string device_file;
  std::string csv_file;
};

bool parse(int argc, char** argv, Arguments& arguments) {
  cvg::SweepParameters& sweep = arguments.sweep;
  options::options_description description("frequency_response");
  arguments.configuration.addTo(description);
  const auto number = [](double& target) { return options::value(&target)->default_value(target); };
  description.add_options()("help,h", "this text")("centre", number(sweep.centre),
                                                   "of the sweep [Hz]; 0: the device's f0")(
      "span", number(sweep.span), "of the sweep [Hz]")(
      "points", options::value(&sweep.points)->default_value(sweep.points), "in the sweep")(
      "drive", number(sweep.drive), "amplitude [V]; 0: for a tenth of the setpoint at the peak")(
      "settling", number(sweep.settling), "at each frequency [s]")(
      "output,o", options::value(&arguments.device_file),
      "YAML with the section `device` that the identifier reads")(
      "csv", options::value(&arguments.csv_file), "the measured responses");
  const options::variables_map values = parseCommandLine(argc, argv, description);
  if (values.count("help") == 0) return true;
  std::cout << "usage: frequency_response --config FILE [--output DEVICE.yaml] [--csv FILE]\n"
            << description;
  return false;
}

std::string deviceSection(const cvg::FrequencyResponseFit& fit) {
  cvg::DeviceKnowledge device;
  device.natural_frequency = fit.natural_frequency;
  device.quality_factor = fit.quality_factor;
  device.drive_gain = fit.device.drive_gain;
  cvg::Section section{"device", {}};
  device.declare(section.table);
  return "# Measured by frequency_response: swept sine, fit of the response matrix.\n" +
         cvg::configurationYaml(section, {"natural_frequency", "quality_factor", "drive_gain"});
}

std::string csvOf(const std::vector<cvg::FrequencyPoint>& points) {
  std::ostringstream out;
  out.precision(12);
  out << "frequency_hz,xx_real,xx_imag,xy_real,xy_imag,yx_real,yx_imag,yy_real,yy_imag\n";
  for (const cvg::FrequencyPoint& point : points) {
    out << point.frequency;
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        const std::complex<double> value = point.response(row, column);
        out << ',' << value.real() << ',' << value.imag();
      }
    }
    out << '\n';
  }
  return out.str();
}

void print(const cvg::FrequencyResponseFit& fit,
           const std::array<cvg::VibrationMode, 2>& ring_down) {
  std::printf("swept sine\n");
  for (const cvg::VibrationMode& mode : fit.modes) {
    std::printf("  mode       %.6f Hz, Q %.1f\n", mode.frequency, mode.quality_factor);
  }
  std::printf("  split      %.6f Hz\n", fit.split);
  std::printf("  f0         %.6f Hz, Q %.1f\n", fit.natural_frequency, fit.quality_factor);
  std::printf("  gamma      %.5f, %.5f\n", fit.device.gamma1, fit.device.gamma2);
  std::printf("  mu         %.4e, %.4e\n", fit.device.mu1, fit.device.mu2);
  std::printf("  ks         %.5e 1/s^2 from the whole matrix, %.5e by (34) from the peak of x\n",
              fit.device.drive_gain, fit.drive_gain_peak);
  std::printf("  phase      %.4f deg common to all paths; misfit %.1e\n",
              cvg::toDegrees(fit.phase_delay), fit.residual);
  std::printf("ring-down\n");
  for (const cvg::VibrationMode& mode : ring_down) {
    std::printf("  mode       %.6f Hz, Q %.1f\n", mode.frequency, mode.quality_factor);
  }
  std::printf("  split      %.6f Hz\n", ring_down[1].frequency - ring_down[0].frequency);
}

void run(Arguments& arguments) {
  const cvg::LoopConfiguration configuration = arguments.configuration.read();
  cvg::SweepParameters& sweep = arguments.sweep;
  if (sweep.centre == 0.0) sweep.centre = configuration.device.natural_frequency;
  if (sweep.drive == 0.0) {
    const double w0 = cvg::kTwoPi * sweep.centre;
    sweep.drive = 0.1 * configuration.control.amplitude * w0 * w0 /
                  (configuration.device.drive_gain * configuration.device.quality_factor);
  }
  cvg::ParameterTable table;
  sweep.declare(table);
  cvg::requireInRange(table, "--");
  cvg::requireApart({arguments.device_file, arguments.csv_file}, configuration.files);
  cvg::WholeFile device_file(arguments.device_file);
  cvg::WholeFile csv_file(arguments.csv_file);
  const double total = 2.0 * static_cast<double>(sweep.points) * (sweep.settling + sweep.averaging);
  ProgressBar progress(total);
  const auto seed = static_cast<std::uint64_t>(configuration.run.seed);
  const std::vector<cvg::FrequencyPoint> points =
      cvg::sweepSine(configuration.plant, configuration.converter, configuration.demodulation,
                     sweep, seed, [&](double share) { progress.showNow(share * total); });
  progress.clear();
  const cvg::FrequencyResponseFit fit = cvg::fitFrequencyResponse(points);
  print(fit, cvg::fitRingDown(cvg::recordRingDown(configuration.plant, configuration.converter,
                                                  configuration.demodulation, sweep, seed)));
  device_file.finish(deviceSection(fit));
  csv_file.finish(csvOf(points));
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    Arguments arguments;
    arguments.sweep.drive = 0.0;
    if (parse(argc, argv, arguments)) run(arguments);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
