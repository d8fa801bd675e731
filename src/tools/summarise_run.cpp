// rosrun ring_gyro summarise_run: what a recorded run achieved, as tables, JSON and series for
// plots.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <string>

#include "command_line.h"
#include "ring_gyro/analysis/run_record.h"
#include "ring_gyro/analysis/run_summary.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/ros/bag_signals.h"
#include "ring_gyro/ros/messages.h"
#include "run_report.h"

namespace ring_gyro {
namespace {

namespace options = boost::program_options;

struct Arguments {
  std::string bag_file;
  std::string json_file;
  std::string csv_directory;
  SummaryOptions summary;
};

/// Nothing when the program has already said what was asked (--help).
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
    std::cout << "usage: summarise_run BAG [--json FILE] [--csv DIRECTORY]\n" << description;
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

/// Topics are told apart by type, so that namespaces and remapping do not matter.
RunRecord readBag(const std::string& path) {
  BagFile bag(path);
  bag.requireWhole();
  std::map<std::string, std::string> topics;  // by type
  for (const BagConnection& connection : bag.connections()) {
    const auto [found, fresh] = topics.emplace(connection.type, connection.topic);
    if (!fresh && found->second != connection.topic &&
        connection.type.rfind("ring_gyro/", 0) == 0) {
      throw BagError(path + ": two topics of " + connection.type + ", " + found->second + " and " +
                     connection.topic + ": filter one out with rosbag filter");
    }
  }
  for (const char* type : {"ring_gyro/OrbitalElements", "ring_gyro/ControlGains"}) {
    if (topics.count(type) == 0) {
      throw BagError(path + ": no messages of " + type +
                     "; record the topics orbital_elements and control_gains");
    }
  }
  RunRecord record;
  BagSinks sinks;
  const auto add = [&record](const auto& signal) { record.add(signal); };
  addSignals<ring_gyro_msgs::OrbitalElements, OrbitalElements>(bag, add, sinks);
  addSignals<ring_gyro_msgs::ControlGains, ControlGains>(bag, add, sinks);
  addSignals<ring_gyro_msgs::PlantTruth, PlantTruth>(bag, add, sinks);
  addSignals<ring_gyro_msgs::ParameterEstimate, ParameterEstimate>(bag, add, sinks);
  try {
    bag.read(sinks);
  } catch (const std::exception& error) {
    throw BagError(path + ": " + error.what());
  }
  bag.requireWhole();
  return record;
}

void run(const Arguments& arguments) {
  const RunRecord record = readBag(arguments.bag_file);
  const RunSummary summary = summarise(record, arguments.summary);
  if (!arguments.csv_directory.empty()) writeSeries(record, summary, arguments.csv_directory);
  if (!arguments.json_file.empty()) {
    writeWholeFile(arguments.json_file, summaryJson(record, summary));
  }
  std::fputs(summaryText(record, summary).c_str(), stdout);
}

}  // namespace
}  // namespace ring_gyro

int main(int argc, char** argv) {
  try {
    if (const auto arguments = ring_gyro::parse(argc, argv)) ring_gyro::run(*arguments);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "summarise_run: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
