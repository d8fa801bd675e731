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

constexpr int kDoubtful = 2;
constexpr char kExitText[] =
    "\nExit status: 0 summarised; 2 summarised, but messages were left out or the identification "
    "does "
    "not fit its data (lines on stderr); 1 no summary.\n";

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

/// Topics are told apart by type, so that namespaces and remapping do not matter.
RunRecord readBag(const std::string& path, RefusedMessages& refused) {
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
    if (readIf<ring_gyro_msgs::OrbitalElements>(instance, elements, refused)) record.add(elements);
    if (readIf<ring_gyro_msgs::ControlGains>(instance, gains, refused)) record.add(gains);
    if (readIf<ring_gyro_msgs::PlantTruth>(instance, truth, refused)) record.add(truth);
    if (readIf<ring_gyro_msgs::ParameterEstimate>(instance, estimate, refused))
      record.add(estimate);
  }
  return record;
}

/// What a user may not overlook goes to standard error, a line each. Returns the exit status.
int run(const Arguments& arguments) {
  std::vector<std::string> outputs = seriesFiles(arguments.csv_directory);
  outputs.push_back(arguments.json_file);
  requireApart(outputs, {arguments.bag_file});
  requireWritable(arguments.json_file);
  RunRecord record;
  RefusedMessages refused;
  try {
    record = readBag(arguments.bag_file, refused);
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
  std::fflush(stdout);
  const auto say = [&arguments](const std::string& line) {
    if (!line.empty()) std::fprintf(stderr, "%s: %s\n", arguments.bag_file.c_str(), line.c_str());
  };
  say(refused.text());
  say(summary.misfit);
  return summary.misfit.empty() && refused.count == 0 ? EXIT_SUCCESS : kDoubtful;
}

}  // namespace
}  // namespace ring_gyro

int main(int argc, char** argv) {
  try {
    const auto arguments = ring_gyro::parse(argc, argv);
    return arguments ? ring_gyro::run(*arguments) : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "summarise_run: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
