// rosrun ring_gyro summarise_run: what a recorded run achieved, as tables, JSON and series for
// plots.

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bag_message.h"
#include "command_line.h"
#include "ring_gyro/analysis/run_record.h"
#include "ring_gyro/analysis/run_summary.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
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
  rosbag::Bag bag(path);
  rosbag::View view(bag);
  std::map<std::string, std::string> topics;  // by type
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    const auto [found, fresh] = topics.emplace(connection->datatype, connection->topic);
    if (!fresh && found->second != connection->topic &&
        connection->datatype.rfind("ring_gyro/", 0) == 0) {
      throw std::runtime_error("two topics of " + connection->datatype + ", " + found->second +
                               " and " + connection->topic + ": filter one out with rosbag filter");
    }
  }
  for (const char* type : {"ring_gyro/OrbitalElements", "ring_gyro/ControlGains"}) {
    if (topics.count(type) == 0) {
      throw std::runtime_error(std::string("no messages of ") + type +
                               "; record the topics orbital_elements and control_gains");
    }
  }
  RunRecord record;
  OrbitalElements elements;
  ControlGains gains;
  PlantTruth truth;
  ParameterEstimate estimate;
  for (const rosbag::MessageInstance& instance : view) {
    if (const auto end = instance.instantiate<ring_gyro_msgs::EndOfRun>()) {
      record.end(end->session, end->last_sequence);
    }
    if (readIf<ring_gyro_msgs::OrbitalElements>(instance, elements)) record.add(elements);
    if (readIf<ring_gyro_msgs::ControlGains>(instance, gains)) record.add(gains);
    if (readIf<ring_gyro_msgs::PlantTruth>(instance, truth)) record.add(truth);
    if (readIf<ring_gyro_msgs::ParameterEstimate>(instance, estimate)) record.add(estimate);
  }
  return record;
}

void run(const Arguments& arguments) {
  std::vector<std::string> outputs = seriesFiles(arguments.csv_directory);
  outputs.push_back(arguments.json_file);
  requireApart(outputs, {arguments.bag_file});
  requireWritable(arguments.json_file);
  RunRecord record;
  try {
    record = readBag(arguments.bag_file);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(arguments.bag_file + ": " + error.what() +
                             "; is it a whole bag? One that was cut: rosbag reindex");
  } catch (const std::exception& error) {
    throw std::runtime_error(arguments.bag_file + ": " + error.what());
  }
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
