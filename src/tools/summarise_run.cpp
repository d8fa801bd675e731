// rosrun ring_gyro summarise_run: results of a recorded run, as tables, JSON and series for plots.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "ring_gyro/analysis/run_record.h"
#include "ring_gyro/analysis/run_summary.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/ros/bag_signals.h"
#include "ring_gyro/ros/messages.h"
#include "run_report.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr int kDoubtful = 2;
constexpr char kExitText[] =
    "\nExit status: 0 summarised; 2 summarised, but messages were left out or the identification "
    "does "
    "not fit its data (lines on stderr); 1 no summary.\n";

struct Arguments {
  std::string bag_file;
  std::string json_file;
  std::string csv_directory;
  cvg::SummaryOptions summary;
};

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  options::options_description description("summarise_run");
  description.add_options()("help,h", "this text")("bag", options::value(&arguments.bag_file),
                                                   "recorded run (or the only argument)")(
      "json", options::value(&arguments.json_file), "file for the figures, SI units")(
      "csv", options::value(&arguments.csv_directory), "folder for the series that plots need")(
      "settling", options::value(&arguments.summary.settling)->default_value(1.0),
      "after the first lock, before anything is judged [s]")(
      "window", options::value(&arguments.summary.rate_window)->default_value(0.1, "0.1"),
      "of the rates [s]");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag", 1);
  if (values.count("help") != 0) {
    std::cout << "usage: summarise_run BAG [--json FILE] [--csv DIRECTORY]\n"
              << description << kExitText;
    return std::nullopt;
  }
  if (arguments.bag_file.empty()) {
    throw options::error("the bag is missing; see summarise_run --help");
  }
  if (!(arguments.summary.settling >= 0.0) || !(arguments.summary.rate_window > 0.0)) {
    throw options::error("--settling must be at least 0 s and --window above 0 s");
  }
  return arguments;
}

/// Topics are recognised by type, so that namespaces and remapping do not matter.
cvg::RunRecord readBag(const std::string& path, bridge::RefusedMessages& refused) {
  bridge::BagFile bag(path);
  bag.requireWhole();
  std::map<std::string, std::string> topics;  // by type
  for (const bridge::BagConnection& connection : bag.connections()) {
    const auto [found, fresh] = topics.emplace(connection.type, connection.topic);
    if (!fresh && found->second != connection.topic &&
        connection.type.rfind("ring_gyro/", 0) == 0) {
      throw bridge::BagError(path + ": two topics of " + connection.type + ", " + found->second +
                             " and " + connection.topic + ": filter one out with rosbag filter");
    }
  }
  for (const char* type : {"ring_gyro/OrbitalElements", "ring_gyro/ControlGains"}) {
    if (topics.count(type) == 0) {
      throw bridge::BagError(path + ": no messages of " + type +
                             "; record the topics orbital_elements and control_gains");
    }
  }
  cvg::RunRecord record;
  bridge::BagSinks sinks;
  const auto add = [&record](const auto& signal) { record.add(signal); };
  bridge::addSignals<ring_gyro::OrbitalElements, cvg::OrbitalElements>(bag, add, sinks, refused);
  bridge::addSignals<ring_gyro::ControlGains, cvg::ControlGains>(bag, add, sinks, refused);
  bridge::addSignals<ring_gyro::PlantTruth, cvg::PlantTruth>(bag, add, sinks, refused);
  bridge::addSignals<ring_gyro::ParameterEstimate, cvg::ParameterEstimate>(bag, add, sinks,
                                                                           refused);
  bridge::addMessages<ring_gyro::EndOfRun>(
      bag, [&record](const auto& end) { record.end(end.session, end.last_sequence); }, sinks);
  try {
    bag.read(sinks);
  } catch (const std::exception& error) {
    throw bridge::BagError(path + ": " + error.what());
  }
  bag.requireWhole();
  return record;
}

/// Prints what a user must not overlook to standard error, a line each. Returns the exit status.
int run(const Arguments& arguments) {
  std::vector<std::string> outputs = seriesFiles(arguments.csv_directory);
  outputs.push_back(arguments.json_file);
  cvg::requireApart(outputs, {arguments.bag_file});
  // Make the folder of the series first, because the JSON may be written there.
  if (!arguments.csv_directory.empty()) makeSeriesFolder(arguments.csv_directory);
  cvg::requireWritable(arguments.json_file);
  bridge::RefusedMessages refused;
  const cvg::RunRecord record = readBag(arguments.bag_file, refused);
  const cvg::RunSummary summary = summarise(record, arguments.summary);
  if (!arguments.csv_directory.empty()) writeSeries(record, summary, arguments.csv_directory);
  if (!arguments.json_file.empty()) {
    cvg::writeWholeFile(arguments.json_file, summaryJson(record, summary));
  }
  std::fputs(summaryText(record, summary).c_str(), stdout);
  std::fflush(stdout);
  const auto say = [&arguments](const std::string& line) {
    if (!line.empty()) std::fprintf(stderr, "%s: %s\n", arguments.bag_file.c_str(), line.c_str());
  };
  say(refused.text());
  say(summary.misfit);
  return summary.misfit.empty() && refused.count == 0 ? EXIT_SUCCESS : kDoubtful;
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  try {
    const auto arguments = ring_gyro::tools::parse(argc, argv);
    return arguments ? ring_gyro::tools::run(*arguments) : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "summarise_run: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
