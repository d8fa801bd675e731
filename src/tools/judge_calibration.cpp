// rosrun ring_gyro judge_calibration: how good a calibration is, on a simulated rate table.

#include <algorithm>
#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "configuration_options.h"
#include "harmonics_json.h"
#include "progress_bar.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/simulation/calibration_judgement.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr int kNotAllJudged = 2;  // exit status: the rows that could be judged are written

struct Case {
  std::string name;
  cvg::LoopConfiguration configuration;
};

/// The whole calibration, then each of its parts switched off, then all of them.
std::vector<Case> casesOf(const cvg::LoopConfiguration& whole, bool each_switch) {
  std::vector<Case> cases = {{"calibrated", whole}};
  if (!each_switch) return cases;
  const std::pair<const char*, bool cvg::Corrections::*> switches[] = {
      {"correct_pickoff", &cvg::Corrections::correct_pickoff},
      {"correct_phase", &cvg::Corrections::correct_phase},
      {"correct_drive_gains", &cvg::Corrections::correct_drive_gains},
      {"correct_phase_mismatch", &cvg::Corrections::correct_phase_mismatch},
      {"cancel_damping", &cvg::Corrections::cancel_damping},
      {"cancel_drift", &cvg::Corrections::cancel_drift},
      {"map_angle", &cvg::Corrections::map_angle}};
  cvg::LoopConfiguration none = whole;
  for (const auto& [name, member] : switches) {
    cvg::LoopConfiguration without = whole;
    without.corrections.*member = false;
    none.corrections.*member = false;
    cases.push_back({std::string("without ") + name, without});
  }
  cases.push_back({"without all of them", none});
  return cases;
}

nlohmann::json jsonOf(const std::string& name, const cvg::CalibrationJudgement& judged) {
  return {{"case", name},
          {"rate", judged.rate},
          {"forward_peak", judged.forward_peak},
          {"backward_peak", judged.backward_peak},
          {"drift", tools::jsonOf(judged.drift)},
          {"drift_peak_to_peak", judged.drift_peak_to_peak},
          {"threshold", judged.threshold},
          {"angle_error", tools::jsonOf(judged.angle_error)},
          {"slope_error", judged.slope_error}};
}

/// Prints a row for each case and rate; returns the same as JSON in SI units.
nlohmann::json judge(const cvg::LoopConfiguration& whole, double time, bool each_switch) {
  nlohmann::json rows = nlohmann::json::array();
  std::printf("%-28s %13s %13s %13s %15s %17s %13s\n", "", "rate [deg/s]", "p-p + [deg/s]",
              "p-p - [deg/s]", "drift p-p [deg/s]", "threshold [deg/s]", "slope [ppm]");
  for (const Case& one : casesOf(whole, each_switch)) {
    for (const double rate : whole.calibration_run.verification_rates) {
      ProgressBar progress(1.0, "of " + one.name);
      std::string failure;
      cvg::CalibrationJudgement judged;
      try {
        judged = cvg::judgeCalibration(one.configuration, rate, time,
                                       [&](double done) { progress.show(done); });
      } catch (const std::exception& error) {
        failure = error.what();  // for example: at a rate below its drift the pattern stops
      }
      progress.clear();
      if (!failure.empty()) {
        std::printf("%-28s %13.4g %s\n", one.name.c_str(), cvg::toDegrees(rate), failure.c_str());
        rows.push_back({{"case", one.name}, {"rate", rate}, {"failure", failure}});
        continue;
      }
      std::printf("%-28s %13.4g %13.6f %13.6f %15.6f %17.6f %13.2f\n", one.name.c_str(),
                  cvg::toDegrees(judged.rate), cvg::toDegrees(judged.forward_peak),
                  cvg::toDegrees(judged.backward_peak), cvg::toDegrees(judged.drift_peak_to_peak),
                  cvg::toDegrees(judged.threshold), 1e6 * judged.slope_error);
      std::fflush(stdout);
      rows.push_back(jsonOf(one.name, judged));
    }
  }
  return rows;
}

std::string firstFailure(const nlohmann::json& rows) {
  for (const nlohmann::json& row : rows) {
    if (row.contains("failure")) return row["failure"].get<std::string>();
  }
  return "";
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    ConfigurationOptions configuration_options;
    double time = 0.0;
    bool each_switch = false;
    std::string json_file;
    options::options_description description("judge_calibration");
    configuration_options.addTo(description);
    description.add_options()("help,h", "this text")(
        "time", options::value(&time)->default_value(150.0),
        "at each rate and sign, at least a turn and a quarter of the pattern [s]")(
        "json", options::value(&json_file), "file for the same in SI units")(
        "each-switch", options::bool_switch(&each_switch),
        "also with each part of the calibration switched off");
    const options::variables_map values = parseCommandLine(argc, argv, description);
    if (values.count("help") != 0) {
      std::cout << "usage: judge_calibration --config FILE --config CALIBRATION [--each-switch]\n"
                << description;
      return EXIT_SUCCESS;
    }
    const cvg::LoopConfiguration configuration = configuration_options.read();
    cvg::requireApart({json_file}, configuration.files);
    cvg::requireWritable(json_file);
    const nlohmann::json rows = judge(configuration, time, each_switch);
    if (!json_file.empty()) cvg::writeWholeFile(json_file, rows.dump(1) + "\n");
    const auto failed = std::count_if(rows.begin(), rows.end(), [](const nlohmann::json& row) {
      return row.contains("failure");
    });
    if (failed == 0) return EXIT_SUCCESS;
    std::fprintf(stderr,
                 "judge_calibration: %ld of %lu judgements could not be made; the first: %s\n",
                 static_cast<long>(failed), static_cast<unsigned long>(rows.size()),
                 firstFailure(rows).c_str());
    return kNotAllJudged;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
